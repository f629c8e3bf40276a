"""How does a reading travel in ROS 2? As a WrenchStamped and raw counts, laid out as plain dictionaries.

    geometry_msgs/msg/WrenchStamped   header {stamp {sec, nanosec}, frame_id}, wrench {force, torque}, each {x, y, z}
    std_msgs/msg/UInt32MultiArray     layout {dim [{label, size, stride}], data_offset}, data

The frame is the pad's: x shear, z up from the coils' top face, y so that it is right-handed; the torque is about where
the calibration's force acts. A force that presses, F_z > 0, is a force along -z there. Numbers are SI; a wrench
that the reading does not tell is NaN. With ROS 2 at hand ``rosidl_runtime_py.set_message_fields(message, found)`` fills
a message; nothing of ROS is needed here. Needs the folder of ``sits-mech export DIR --to twin``.
Run ``PYTHONPATH=FOLDER python studies/robots/ros2_message.py FOLDER CODE CODE ...``.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from twin import WRENCH, Twin

Message = dict[str, Any]


def stamped(wrench: Sequence[float], nanoseconds: int, frame: str = "sits_pad") -> Message:
    """Return a WrenchStamped of a wrench F_x, F_z, M, F_y, M_x, M_z [N, N m] at a time since the epoch [ns]."""
    of = dict(zip(WRENCH, (float(value) for value in wrench), strict=True))
    force = {"x": of["F_x"], "y": of["F_y"], "z": -of["F_z"]}
    torque = {"x": of["M_x"], "y": of["M"], "z": of["M_z"]}
    stamp = {"sec": nanoseconds // 10**9, "nanosec": nanoseconds % 10**9}
    return {"header": {"stamp": stamp, "frame_id": frame}, "wrench": {"force": force, "torque": torque}}


def counts(codes: Sequence[int]) -> Message:
    """Return a UInt32MultiArray of the converter's codes, a channel a coil."""
    data = [int(code) for code in codes]
    dim = [{"label": "coil", "size": len(data), "stride": len(data)}]
    return {"layout": {"dim": dim, "data_offset": 0}, "data": data}


def messages(twin: Twin, codes: Sequence[int], nanoseconds: int) -> dict[str, Message]:
    """Return both messages of a reading by the topics they belong to."""
    estimate = twin.estimate_codes(np.array([codes]))
    return {"sits/wrench": stamped(estimate.wrench[0], nanoseconds), "sits/counts": counts(codes)}


if __name__ == "__main__":
    found = messages(Twin.load(Path(sys.argv[1]) / "sensor.npz"), [int(word) for word in sys.argv[2:]], 0)
    print(json.dumps(found, indent=2))
