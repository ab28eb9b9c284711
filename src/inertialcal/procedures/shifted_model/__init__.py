"""Shifted ground model: flips over several flights shift the bias of a model that was made on the ground."""
