"""Evaluation of quality, stability and cost: networks and fillings, pixel orders, shares of traced pixels."""
