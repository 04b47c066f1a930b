"""The lights, what a baked head looks like in them, and what stands in their way."""
