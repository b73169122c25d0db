"""Where is the Sun?"""
