"""Results as pictures: data to axes, no computing."""
