"""The paper itself: what it prints, what we get, and where the two differ."""
