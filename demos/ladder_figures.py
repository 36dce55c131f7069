"""Figures of the ladder's rungs, in the style of hybrid.output.figures."""

import numpy as np

from hybrid.output.figures import COLOURS, COLUMN, MARKERS, PAGE, figure

HOLLOW = {"markerfacecolor": "white", "markeredgewidth": 0.9}


def letters(panels, titles):
    """(a), (b) ... and what each panel shows."""
    for letter, panel, title in zip("abcdefgh", np.ravel(panels), titles):
        panel.set_title(f"({letter}) {title}", loc="left", fontsize=9)


def slope(panel, order, sizes, error):
    """A grey line of an order from a point of the finest size over a doubling."""
    x = np.array([sizes.min(), 2 * sizes.min()])
    panel.loglog(x, error * (x / x[0]) ** order, color="#888888", linewidth=0.8)
    panel.annotate(f"{order}", (x[1], error * 2**order), (3, 0), textcoords="offset points", color="#555555",
                   va="center", fontsize=8)


def ticks(panel, sizes, text="{:g}"):
    panel.set_xticks(sizes, [text.format(size) for size in sizes])
    panel.minorticks_off()


def columns(path, curves, profiles):
    """Errors against cells of three columns, and their stresses."""
    methods = list(dict.fromkeys(method for _, method in curves))
    with figure(path, PAGE, 1.5 * COLUMN) as drawing:
        top, bottom = drawing.subplots(2, len(profiles))
        for panel, case in zip(top, profiles):
            for i, method in enumerate(methods):
                cells, errors = curves[case, method]
                for kind, style in ((0, "-"), (1, ":")):
                    panel.loglog(cells, errors[:, kind], MARKERS[i] + style, color=COLOURS[i], **HOLLOW,
                                 label=method if kind == 0 else None)
            ticks(panel, cells, "{:d}")
            panel.set_xlabel("cells")
        top[0].set_ylabel("error of stress (–), height (···) [-]")
        top[-1].legend(loc="lower left", fontsize=7)
        for panel, (column, found) in zip(bottom, profiles.values()):
            Z = np.linspace(0, column.length, 200)
            for i, method in enumerate(found):
                panel.plot(found[method].stress / column.weight, found[method].Z / column.length, MARKERS[2 * i],
                           color=COLOURS[2 * i], label=method, **HOLLOW)
            panel.plot(Z / column.length - 1, Z / column.length, color="black", linewidth=0.8, label="exact")
            panel.set_xlabel(r"$\sigma_{zz}/\rho g L$")
        bottom[0].set_ylabel("initial height $Z/L$")
        bottom[0].legend(loc="lower right", fontsize=7)
        letters(top, profiles)
        letters_after(bottom, len(profiles), "32 cells")
    return path


def letters_after(panels, count, title):
    for letter, panel in zip("abcdefgh"[count:], panels):
        panel.set_title(f"({letter}) {title}", loc="left", fontsize=9)


def cantilever(path, curves, bent, elastica, beam):
    """Bent shape with the axial stress, and errors of the tip."""
    with figure(path, PAGE, COLUMN) as drawing:
        shape, drop, short = drawing.subplots(1, 3, gridspec_kw={"width_ratios": (1, 1.1, 1.1)})
        spread = np.trace(bent.stress, axis1=1, axis2=2) / 1e6
        limit = np.abs(spread).max()
        dots = shape.scatter(bent.position[:, 0], bent.position[:, 2], c=spread, s=4, cmap="RdBu_r", vmin=-limit,
                             vmax=limit)
        drawing.colorbar(dots, ax=shape, label=r"tr $\sigma$ [MPa]", aspect=40)
        for (down, back), marker, label in ((elastica, "s", "elastica"), (beam, "D", "Hencky fibres")):
            shape.plot(10 - back, 0.5 - down, marker, color="black", label=label, markersize=5, markerfacecolor="none")
        shape.set_aspect("equal")
        shape.set_xlabel("$x$ [m]")
        shape.set_ylabel("$z$ [m]")
        shape.legend(loc="lower left", fontsize=7, borderpad=0.1, handletextpad=0.1)
        for k, panel in enumerate((drop, short)):
            for i, (case, (sizes, errors)) in enumerate(curves.items()):
                panel.loglog(sizes, 100 * errors[:, k], MARKERS[i] + "-", color=COLOURS[i], label=case, **HOLLOW)
            ticks(panel, np.unique(np.concatenate([sizes for sizes, _ in curves.values()])))
            panel.tick_params(axis="x", labelrotation=60)
            panel.set_xlabel("cell [m]")
            panel.set_ylim(0.02, 10)
            panel.set_yticks((0.1, 0.2, 0.5, 1, 2, 5, 10), ("0.1", "0.2", "0.5", "1", "2", "5", "10"))
        drop.set_ylabel("off the beam of Hencky fibres [%]")
        short.legend(loc="lower right", fontsize=7)
        letters((shape, drop, short), ("cells of 0.5 m", "drop", "shortening"))
    return path


def manufactured(path, space, steps):
    """Errors in space of displacement and stress, and in time."""
    cases = list(dict.fromkeys(case for case, _ in space))
    with figure(path, PAGE, COLUMN) as drawing:
        panels = drawing.subplots(1, 3)
        for k, panel in enumerate(panels[:2]):
            for (case, method), (sizes, errors) in space.items():
                i = cases.index(case)
                panel.loglog(sizes, errors[:, k], MARKERS[i] + ("-" if method == "GIMP" else ":"), color=COLOURS[i],
                             label=case if method == "GIMP" else None, **HOLLOW)
            finest = space[cases[0], "GIMP"][0]
            slope(panel, 2, finest, 0.4 * min(errors[:, k].min() for _, errors in space.values()))
            if k:
                slope(panel, 1, finest, 0.4 * space[cases[0], "GIMP"][1][-1, 1])
            ticks(panel, finest, "{:.2g}")
            panel.set_xlabel("cell $h/L$")
        panels[0].plot([], [], color="black", label="GIMP")
        panels[0].plot([], [], ":", color="black", label="standard MPM")
        panels[0].legend(loc="lower right", fontsize=6.5)
        panels[0].set_ylabel("error [-]")
        for i, (name, (step, errors)) in enumerate(steps.items()):
            label = name.replace("ρ∞", r"$\rho_\infty$").replace("α", r"$\alpha$")
            panels[2].loglog(step, errors, MARKERS[i] + "-", color=COLOURS[i], label=label, markersize=6 - 1.5 * i,
                             **HOLLOW)
        first = next(iter(steps.values()))
        for order, (step, errors) in ((2, first), (1, first)):
            slope(panels[2], order, step, 0.5 * errors.min())
        ticks(panels[2], first[0], "{:.2g}")
        panels[2].set_xlabel(r"step $\Delta t$ [s]")
        panels[2].legend(loc="lower right", fontsize=6.5)
        panels[2].set_ylim(bottom=0.1 * first[1].min())
        letters(panels, ("displacement, in space", "stress, in space", "displacement, in time"))
    return path


def wave(path, rides, module):
    """The pulse on its way and at the end, and its energy."""
    with figure(path, PAGE, 0.85 * COLUMN) as drawing:
        shape, energy = drawing.subplots(1, 2)
        Z, scale = np.linspace(0, module.LENGTH, 400), module.AMPLITUDE
        shape.plot(Z, -module.pulse(Z)[0] / scale, color="black", linewidth=0.8, label="exact, $t = 2L/c$")
        for i, (name, found) in enumerate(rides.items()):
            label = name.replace("ρ∞", r"$\rho_\infty$").replace("α", r"$\alpha$")
            shape.plot(found.Z, found.displacement[-1] / scale, MARKERS[i], color=COLOURS[i], label=label, **HOLLOW,
                       markersize=5 - i)
            energy.plot(found.times * module.SPEED / module.LENGTH, found.energy, color=COLOURS[i], label=label,
                        linewidth=3 - 0.6 * i)
        shape.set_xlabel("$Z/L$")
        shape.set_ylabel("$u/A$")
        shape.legend(fontsize=7)
        energy.set_xlabel("$c t/L$")
        energy.set_ylabel("energy / that of the start")
        energy.set_ylim(0, 1.05)
        energy.legend(loc="lower left", fontsize=7)
        letters((shape, energy), ("pulse, reflected by both ends", "energy"))
    return path


def dimensions(path, ratios):
    """What three dimensions cost more than collapsed axes."""
    with figure(path, COLUMN, 0.6 * COLUMN) as drawing:
        panel = drawing.subplots()
        place = np.arange(len(ratios))
        for k, label in enumerate(("unknowns", "time")):
            bars = panel.bar(place + 0.35 * k - 0.175, [r[k] for r in ratios.values()], 0.33, color=COLOURS[k],
                             label=label)
            panel.bar_label(bars, fmt="%.1f", fontsize=7)
        panel.set_xticks(place, [case.replace(", ", ",\n") for case in ratios])
        panel.set_ylabel("3-D / collapsed axes")
        panel.margins(y=0.15)
        panel.legend()
    return path


def footing(path, curves, module):
    """Force against settlement for three friction angles."""
    across = sorted({n for _, _, n in curves})
    with figure(path, PAGE, 0.85 * COLUMN) as drawing:
        panels = drawing.subplots(1, 3)
        for panel, angle in zip(panels, (0, 20, 30)):
            exact = module.prandtl(angle)
            for i, n in enumerate(across):
                for name, style in zip(module.CURES, ("-", ":", "--")):
                    if (angle, name, n) in curves:
                        found = curves[angle, name, n]
                        panel.plot(100 * np.append(0, found.settlement), np.append(0, found.factor), style,
                                   color=COLOURS[i], label=f"{name}, {n}")
            panel.axhline(exact, color="black", linewidth=0.8)
            panel.annotate(f"{exact:.2f}", (0, exact), (3, 3), textcoords="offset points", fontsize=8)
            panel.set_xlabel("settlement / $B$ [%]")
            panel.set_ylim(bottom=0)
        panels[0].set_ylabel("$F/(Bc)$")
        panels[-1].legend(loc="lower right", fontsize=6, title="cells in $B/2$", title_fontsize=7)
        letters(panels, (rf"$\varphi$ = {a}°" for a in (0, 20, 30)))
    return path
