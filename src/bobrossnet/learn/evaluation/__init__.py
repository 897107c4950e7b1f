"""How good, how steady and how costly pictures are: networks and fillings, pixel orders, shares of traced pixels."""
