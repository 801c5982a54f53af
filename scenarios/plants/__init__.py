"""Simulated arms behind one interface."""
