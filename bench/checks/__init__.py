"""Tests of measurements that cost too much for every run of the suite."""
