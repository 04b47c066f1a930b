"""Networks that see shadows from outside where a test wants them."""

import torch


class Says(torch.nn.Module):
    """A network that sees a shadow of some logs in the left half, whatever it is shown; mirrored, in the right one."""

    def __init__(self, red=-1.0, green=-1.0, blue=-1.0, columns=128):
        super().__init__()
        self.shadow, self.columns, self.shown = torch.tensor([red, green, blue]), columns, []

    def forward(self, photo, parts):
        self.shown.append((photo, parts))
        logs = torch.zeros(2, 3, 256, 256)
        logs[0, :, :, : self.columns] = self.shadow[:, None, None]
        logs[1, :, :, 256 - self.columns :] = self.shadow[:, None, None]
        return logs


class Draws(torch.nn.Module):
    """A network that sees shadows where a mask (256, 256) says so."""

    def __init__(self, mask):
        super().__init__()
        self.mask = mask

    def forward(self, photo, parts):
        return -torch.stack([self.mask, self.mask.flip(-1)])[:, None].expand(2, 3, 256, 256)
