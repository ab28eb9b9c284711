"""Certificate of a campaign: what it states, what it lacks, as XML (a DCC), as PDF, read back and signed."""
