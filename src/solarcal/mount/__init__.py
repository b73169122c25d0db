"""How do the axes see it?"""
