"""Pictures of runs, replays, sweeps, traces and logs: tools/tribo-plot."""
