"""The lab: instruments that are read and set while a test goes on, and what is recorded of them.

``clock`` is the one clock of an acquisition. ``instruments`` holds the protocol of an instrument, dialects (what is
said to an instrument, as data), links (how its bytes come) and devices made of the two. ``acquisition`` reads LAB.toml,
records, watches and seals. ``guide`` tells a person with an IMU in the hand what to do next.
"""
