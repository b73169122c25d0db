"""What errors does it have?"""
