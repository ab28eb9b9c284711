"""A campaign: one folder, one campaign.toml, every test of an item, one ``out/``.

The one place that joins files, procedures and decisions. ``load`` reads and judges the campaign file, ``run``
does everything and writes ``out/``.
"""
