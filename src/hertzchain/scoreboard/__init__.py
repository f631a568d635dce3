"""The theories against the integration, over tapers that none was fitted to."""
