"""The classical side: model-based laws to compare against, one file per controller."""
