"""The commands, one file each; the group loads a file when its command is used."""
