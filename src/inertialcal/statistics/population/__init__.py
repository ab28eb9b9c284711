"""Figures of many units: what the population scatters, stations, outliers, gauges, yields."""
