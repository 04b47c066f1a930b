"""The networks: nothing but torch modules."""
