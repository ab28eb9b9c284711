"""Sequence: steps that set, wait until all is steady, record, and are PASS once the record was read again.

bluesky's RunEngine was tried first (1.15.1, Python 3.11, two cores, November 2026). The steps are our own because:

- After ``kill -9`` a new process finds it ``idle``, and ``RE.resume()`` raises ``TransitionError``: the messages since
  a checkpoint are a deque in memory. What survives a crash, most of what is here, would be ours to write all the same.
- It takes signals, and so the main thread: in another one ``ValueError: signal only works in main thread``.
- Its waits are those of its event loop: a wait of 2 s takes 2.00 s, and no other clock can be given to it. A
  rehearsal of 200 h would take 200 h.
- It brings seven packages and 8 MiB that are not here today; its import takes 0.5 s, a message 0.14 ms.

What it would have given: plans as generators, pause and suspenders.
"""
