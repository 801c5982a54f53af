"""The world of a comparison: arms, loads, plants, motions, one run, a campaign and its store."""
