"""The rigs of lab.py through the whole way, as a table: lab_study.py [NAME...]. Ends with 1 where more than one in nine was divided by what its verdict does not have,
where fewer than nine in ten right loops were accepted, or where a wrong one was."""

import sys
import tempfile
from pathlib import Path

import lab


def main():
    names = sys.argv[1:] or list(lab.RIGS)
    outside, right, wrong, refused = [], [], [], []
    for name in names:
        rig = lab.RIGS[name]
        with tempfile.TemporaryDirectory() as temporary:
            folder = Path(temporary) / "rig"
            code, said = lab.go(rig, folder)
            if code:
                refused.append(name)
                print(f"{name:24} refused ({code}): {said.strip().splitlines()[-1]}", flush=True)
                continue
            verdicts, _ = lab.accepted(rig, folder)
            factor, (likely, least, most) = lab.played(verdicts, folder)
            off = lab.breakaway_off(rig, folder)
        outside += [] if least <= factor <= most else [name]
        print(f"{name:24} {'seen' if name in lab.SEEN else 'unseen':6} divided by {factor:6.3g}, predicted {likely:6.3g}, {least:.3g} to {most:.3g}{'' if least <= factor <= most else '  OUTSIDE'}", flush=True)
        print("    breakaway of the loop is {:+.0%} to {:+.0%} off over the task".format(*off), flush=True)
        for line in said.splitlines():
            if line.startswith(("sensor:", "cogging:", "no law", "friction falls")):
                print(f"{'':4}{line}", flush=True)
        for case, (_, _, against) in verdicts.items():
            takes = lab.OTHERS[case][1]
            (right if takes else wrong).append(takes == (not against))
            if takes != (not against):
                print(f"{'':4}accept, {case}: {'; '.join(against) or 'taken'}", flush=True)
    tuned = len(names) - len(refused)
    print(f"{tuned} of {len(names)} tuned, {len(outside)} outside the printed range; accept took {sum(right)} of {len(right)} right loops and rejected {sum(wrong)} of {len(wrong)} wrong ones")
    return int(len(outside) > max(tuned / 9, 1) or sum(right) < 0.9 * len(right) or not all(wrong) or tuned < 0.8 * len(names))


if __name__ == "__main__":
    sys.exit(main())
