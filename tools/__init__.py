"""What the project needs besides the program: its man page, its packages."""
