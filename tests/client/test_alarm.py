"""The time limit for waits that have none: it rings when it should, and only then."""

import threading
import time

import pytest

from simx_client.transport.time_limit import Alarm


@pytest.fixture
def bell():
    """An alarm, and a semaphore that counts its rings."""
    rings = threading.Semaphore(0)
    alarm = Alarm(rings.release)
    yield alarm, rings
    alarm.close()


def test_it_rings_once_after_the_deadline(bell):
    alarm, rings = bell
    began = time.monotonic()
    alarm.set(began + 0.05)
    assert rings.acquire(timeout=5)
    assert time.monotonic() - began >= 0.05
    assert not rings.acquire(timeout=0.1)


def test_its_thread_runs_before_it_is_needed_as_at_exit_none_can_be_started(bell):
    alarm, _ = bell
    assert alarm._thread.is_alive()


def test_an_earlier_deadline_overtakes_the_one_it_sleeps_for(bell):
    alarm, rings = bell
    alarm.set(time.monotonic() + 60)
    alarm.set(time.monotonic() + 0.01)
    assert rings.acquire(timeout=5)


def test_a_deadline_in_the_past_rings_at_once_also_after_others(bell):
    alarm, rings = bell
    for _ in range(3):
        alarm.set(time.monotonic() + 60)
        alarm.set(0.0)
        assert rings.acquire(timeout=5)


def test_a_cleared_alarm_is_silent_and_a_later_deadline_replaces_an_earlier(bell):
    alarm, rings = bell
    alarm.set(time.monotonic() + 0.02)
    alarm.clear()
    assert not rings.acquire(timeout=0.1)
    alarm.set(time.monotonic() + 0.02)
    alarm.set(time.monotonic() + 60)
    assert not rings.acquire(timeout=0.1)


def test_many_waits_that_end_in_time_never_ring_and_the_next_that_does_not_still_does(bell):
    alarm, rings = bell
    for _ in range(1000):
        alarm.set(time.monotonic() + 0.5)
        alarm.clear()
    alarm.set(time.monotonic() + 0.01)
    assert rings.acquire(timeout=5)
    assert not rings.acquire(timeout=0.6)


def test_closing_ends_the_thread_and_a_deadline_afterwards_is_ignored(bell):
    alarm, rings = bell
    alarm.set(time.monotonic() + 60)
    thread = alarm._thread
    alarm.close()
    thread.join(5)
    assert not thread.is_alive()
    alarm.set(0.0)
    assert not rings.acquire(timeout=0.05)


def test_who_is_setting_the_alarm_may_hold_what_the_bell_waits_for():
    lock, rung = threading.Lock(), threading.Semaphore(0)

    def ring():
        rung.release()
        with lock:
            rung.release()

    alarm = Alarm(ring)
    with lock:
        alarm.set(0.0)
        assert rung.acquire(timeout=5)  # it rings now, and waits for the lock
        alarm.set(time.monotonic() + 60)
        alarm.set(0.0)
        alarm.close()
    assert rung.acquire(timeout=5)
