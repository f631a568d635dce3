"""The browser app: a local server, and the page that it serves."""
