"""Writes a recording: one row per sample, conditions in the first row of each run."""
from experiment import UNITS


def number(x, digits=7):
    return "" if x is None else f"{float(x):.{digits}g}"


def write_recording(e, values, noise, held, with_sd, path, comments=("Made by cases/diagnose/generators; see bench/diagnose_trials.",)):
    events = e.kind == "impact_times"
    head = ["run"] + (["impact [1]", "t [s]"] if events else ["t [s]"])
    if not events:
        for c in e.channels:
            head.append(f"{c} [{UNITS[c]}]")
            if with_sd:
                head.append(f"{c}_sd [{UNITS[c]}]")
    elif with_sd:
        head.append("t_sd [s]")
    head += list(e.conditions) + (["held_out"] if held is not None else [])
    lines = ["# " + c for c in comments] + [",".join(head)]
    for r in range(e.n):
        zero = values[r][0, 0] if events else 0.0  # a stopwatch starts at the first impact it hears
        for i, t in enumerate(e.times[r]):
            row = [str(r + 1)]
            if events:
                row += [str(int(t)), number(values[r][0, i] - zero + 1.0, 8)]
                if with_sd:
                    row.append(number(noise.sd["impact_time"], 3))
            else:
                row.append(number(t, 8))
                for c, name in enumerate(e.channels):
                    row.append(number(values[r][c, i]))
                    if with_sd:
                        row.append(number(noise.sd[name], 3))
            row += [number(v[r]) if i == 0 else "" for v in e.conditions.values()]
            if held is not None:
                row.append(str(held[r]) if i == 0 else "")
            lines.append(",".join(row))
    path.write_text("\n".join(lines) + "\n")
