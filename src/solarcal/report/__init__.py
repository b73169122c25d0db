"""Text, plots and the certificate: what a session looks like on paper and on a screen."""
