"""The live page of an acquisition: `server` gives it to browsers of this computer, `content` is what it shows."""
