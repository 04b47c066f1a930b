"""What a process that makes samples for training starts with."""

from __future__ import annotations

import os
from multiprocessing import parent_process
from threading import Thread

import cv2
import torch


def begin_worker(_number: int = 0) -> None:
    """Keep to one core, and end with the process that trains, however that ends.

    A worker that spread over the cores would take them from the training step. And the fork server stays as long as
    its workers do: one whose training was killed would wait for ever for somebody to take its next sample.
    """
    torch.set_num_threads(1)
    cv2.setNumThreads(1)
    Thread(target=_end_with_training, daemon=True).start()


def _end_with_training() -> None:
    trainer = parent_process()
    if trainer is not None:
        trainer.join()
        os._exit(1)
