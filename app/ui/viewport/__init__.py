"""The picture: which ones are shown and where, and what is drawn, grabbed and said over it."""
