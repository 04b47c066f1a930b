"""OpenCV's decoders, and what they leave behind."""

import threading

import cv2
import numpy as np

from relight_core.imaging.formats.opencv_decoding import decoded_by_opencv

LONG_S, A_MOMENT_S = 60, 0.05


def test_files_decoded_at_a_time_leave_the_log_as_talkative_as_it_was(monkeypatch):
    png = cv2.imencode(".png", np.zeros((2, 2, 3), np.uint16))[1].tobytes()
    decode, second_is_in, first_is_out = cv2.imdecode, threading.Event(), threading.Event()
    second = threading.Thread(target=decoded_by_opencv, args=(png,))

    def decode_overlapping(*arguments):
        if threading.current_thread() is second:
            second_is_in.set()
            first_is_out.wait(LONG_S)
        else:
            second.start()
            second_is_in.wait(A_MOMENT_S)
        return decode(*arguments)

    monkeypatch.setattr(cv2, "imdecode", decode_overlapping)
    level = cv2.utils.logging.getLogLevel()
    assert decoded_by_opencv(png).shape == (2, 2, 3)
    first_is_out.set()
    second.join(LONG_S)
    assert cv2.utils.logging.getLogLevel() == level != cv2.utils.logging.LOG_LEVEL_SILENT
