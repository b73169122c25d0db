"""What the field calculators answer: document, text and drawings, for commands and screens."""
