"""The station in the place of a controller: the Sun, P and O for units that know none of them."""
