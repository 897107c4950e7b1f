"""What the report of 2019 gives, to stand beside what is measured here: *Accelerating rendering by partial inpainting:
BobRossNet*."""

SSIM = {0.01: 0.789893, 0.25: 0.947632, 0.50: 0.970101, 0.75: 0.980241, 1.00: 0.987065}
"""Mean over its 1,050 test samples by share of traced pixels, of the network's own output."""

LOSS = "ssim+l2"
"""What it chose of the five losses, by eye."""
