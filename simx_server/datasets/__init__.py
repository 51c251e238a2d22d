"""Datasets of demonstrations: the episodes of a replay as NumPy files, for LeRobot and for Minari.

A recording replays bit for bit, so images are rendered afterwards: of other cameras, in other sizes, in other light. ::

    `episodes.py`     collects episodes during a replay
    `quantities.py`   the numbers of an observation and of an action, by name
    `cameras.py`      the images of an episode
    `wanted.py`       which images, and in what light
    `npz.py`          NumPy's files
    `lerobot/`        LeRobot's format: tables of Parquet, statistics, films
    `minari.py`       Minari's format, by its own package
"""
