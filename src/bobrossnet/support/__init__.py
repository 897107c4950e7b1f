"""What every part uses: errors, paths, files written whole, threads, interruptions, progress."""
