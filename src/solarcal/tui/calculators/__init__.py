"""The field calculators as forms: which fields each has, and what it makes of them."""
