"""The program: command line and window. Pixels are relight_core's business."""
