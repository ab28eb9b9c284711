"""The report: figures, and one page that holds a whole campaign. Alone imports matplotlib."""
