"""Readers of MATLAB, HDF5, NumPy and Parquet files."""
