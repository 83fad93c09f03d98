"""The error of each setting."""

import math
import threading

import numpy as np

from .. import generators, rotations, states, tables
from ..generators import LENGTH
from ..problems import RunFailed
from . import independent
from .program import kept
from .settings import DEFAULT, FINE, WIDE, ranged

FINEST_STEP, COARSER_FINEST = 0.3125, 1.25  # fs; the second for a quick run


def rms(a):
    return np.sqrt(np.mean(np.sum(np.square(a), axis=-1)))


class Axes:
    def __init__(self, program, folder, quick):
        self.program, self.folder, self.quick = program, folder, quick
        self.finest = COARSER_FINEST if quick else FINEST_STEP
        self.loose = generators.bundle(folder / "loose.h5", rings=1, spacing=24.0)
        self.rings = 2 if quick else 4
        self.tubes = 1 + 3 * self.rings * (self.rings + 1)
        self.scenes = {"weave": self.weave(),
                       "bundle": generators.bundle(folder / "bundle.h5", rings=self.rings)}
        # Scenes for errors alone.
        self.files = self.scenes | {
            "ring": self.moving("ring", {"ring_segments": 200}),
            "film": self.moving("film", {"film_fibres": 60, "film_segments": 30})}

    def weave(self):
        """A plain weave, five segments between crossings as in the paper,
        4 ps after it is let go."""
        file = self.folder / "weave.h5"
        side = 8 if self.quick else 24
        self.weave_size = f"{side} x {side} tubes of {5 * side} segments"
        self.program.run({
            "scene": "weave", "weave_fibres": f"{side},{side}", "weave_segments": 5 * side,
            "scene_perturb": 0.02, "damping_local": 0.4, "ts_dt": 20, "ts_max_steps": 200,
            "pair_points": 5, "state_output": file})
        return file

    def moving(self, scene, options):
        """A scene a few picoseconds after it is let go."""
        file = self.folder / f"{scene}.h5"
        self.program.run({"scene": scene, **options, "damping_local": 0.3, "ts_dt": 10,
                          "ts_max_steps": 200, "pair_points": 5, "state_output": file})
        return file

    def measure(self, settings):
        """Fills in the errors."""
        work = {"time step": self.step, "points": self.points, "range": self.range,
                "length": self.length, "far points": self.far_points, "settings": self.whole,
                "precision": self.precision, "accuracy": self.accuracy}
        self.program.each(lambda s: work[s.axis](s), settings)

    # Two tubes

    @staticmethod
    def sums(options):
        """What `independent` needs of the options."""
        far = None
        if options.get("pair_far_points", options["pair_points"]) < options["pair_points"]:
            far = options["pair_far_points"], options["pair_far_from"]
        return {"splice": options["vdw_splice"], "switch": options["pair_switch"],
                "cutoff": options["pair_cutoff"], "far": far}

    def resting(self, options, T=LENGTH, **more):
        return independent.resting_energies(options["pair_points"], T, **self.sums(options), **more)

    def adhesion(self, splice):
        """Energy per length of two tubes at rest, eV/A, with many points and the default range."""
        return self.resting(dict(FINE, vdw_splice=splice, pair_points=48), offsets=1)[0]

    def two_tubes(self, setting, reference):
        """Adhesion against many points with the reference's range and splice;
        corrugation as it is."""
        exact = self.resting(dict(reference, pair_points=48), offsets=1)[0]
        energy = self.resting(setting.options, setting.length)
        setting.error("two tubes", "adhesion", energy.mean() / exact - 1)
        setting.error("two tubes", "corrugation", np.ptp(energy) / energy.min())

    def check_sums(self, settings):
        """Largest relative difference between the program's energy of two tubes
        and the double sum."""
        def difference(s):
            d, offset, segments = 17.4, 0.3 * LENGTH, round(16 * LENGTH / s.length)
            file = generators.endless_tubes(self.folder / f"two_{id(s)}.h5", [(0, 0), (d, 0)],
                                            [0.0, offset],
                                            generators.Endless(s.length, segments))
            energy = self.program.run(dict(s.options, scene="file", scene_file=file, ts_max_steps=0,
                                           fibre_segment_length=s.length)).energy("pair")
            exact = independent.tube_energy(d, offset, s.options["pair_points"], s.length,
                                            **self.sums(s.options))
            return abs(energy / (16 * LENGTH) / exact - 1)
        return max(self.program.each(difference, settings))

    # Forces

    def forces(self, scene, options):
        state, _ = self.program.final(dict(options, scene="file", scene_file=self.files[scene],
                                           ts_max_steps=0), forces=True)
        return state["force"]

    def force_error(self, setting, reference, measure="force", scenes=None):
        for scene in scenes or self.scenes:
            exact = self.forces(scene, reference)
            pair = exact - self.forces(scene, {"pair": "none"})
            setting.error(scene, measure,
                          rms(self.forces(scene, setting.options) - exact) / rms(pair))

    def points(self, setting):
        fine = dict(setting.options, pair_points=9)
        self.two_tubes(setting, fine)
        if setting.options["pair_points"] < 9:
            self.force_error(setting, fine)

    def range(self, setting):
        # With many points on both sides, so that the range alone differs.
        wide = ranged(setting.options, WIDE)
        if setting.options == wide:
            return
        exact = self.resting(dict(wide, pair_points=24), offsets=1)[0]
        energy = self.resting(dict(setting.options, pair_points=24), offsets=1)[0]
        setting.error("two tubes", "adhesion", energy / exact - 1)
        self.force_error(setting, wide)

    def far_points(self, setting):
        near = {k: v for k, v in setting.options.items() if not k.startswith("pair_far")}
        fine = dict(near, pair_points=9)
        self.two_tubes(setting, fine)
        self.force_error(setting, fine)
        self.force_error(setting, near, "force, by far points alone")
        setting.error("collapse", "energy drift", self.drift(setting.options))
        setting.error("collapse", "energy drift without far points", self.drift(near))

    def accuracy(self, setting):
        # With the usual skin the bundle's box would be too short for so wide a range.
        exact = ranged(dict(DEFAULT, pair_points=24, pair_skin=0.1), WIDE)
        self.force_error(setting, exact, scenes=self.files)

    def single_offered(self):
        """Builds for processors without AVX-512 refuse single precision."""
        try:
            self.forces("weave", dict(FINE, pair_precision="single"))
        except RunFailed as refusal:
            if "AVX-512" not in str(refusal):
                raise
            return False
        return True

    def precision(self, setting):
        self.force_error(setting, dict(setting.options, pair_precision="double"),
                         "force, by precision alone")
        setting.error("collapse", "energy drift", self.drift(setting.options))

    def whole(self, setting):
        """An option file's errors, against the finest with its splice."""
        finest = ranged(dict(FINE, vdw_splice=setting.options["vdw_splice"]), WIDE)
        self.two_tubes(setting, finest)
        self.force_error(setting, finest)
        setting.error("collapse", "energy drift", self.drift(setting.options, setting.dt))

    def drift(self, options, dt=10):
        """Seven tubes 24 A apart fall together. Largest error of the energy
        over the largest kinetic energy."""
        rows, _, _ = self.program.table(dict(
            options, scene="file", scene_file=self.loose, ts_dt=dt,
            ts_max_steps=round(8000 / dt), monitor_interval=1))
        total = rows["total"]
        return np.abs(total - total[0]).max() / rows.motion.max()

    # Time step

    def step(self, setting):
        fibre = {"scene": "fibre", "fibre_segments": 40, "fibre_bend": 1.5, "pair": "none"}
        weave = {"scene": "weave", "weave_fibres": "8,8", "weave_segments": 40,
                 "weave_periodic": None,
                 "scene_perturb": 0.05}
        for scene, options, time in (("fibre", fibre, 600), ("undamped weave", weave, 1200),
                                     ("damped weave", dict(weave, damping_local=0.4), 12000)):
            run, exact = (self.history(dict(options, ts_dt=dt), time)
                          for dt in (setting.dt, self.finest))
            setting.error(scene, "elastic energy", rms(run["elastic"] - exact["elastic"]))
            if scene != "damped weave":
                setting.error(scene, "position, A", rms(run["position"] - exact["position"]))
                setting.error(scene, "energy balance", np.abs(run["balance"]).max())

    @kept
    def history(self, options, time):
        """Final positions; the elastic energy every 300 fs (a multiple of all steps) and the error
        of the balance, both over the elastic energy of the start."""
        dt = options["ts_dt"]
        rows, _, state = self.program.table(dict(
            options, ts_max_steps=round(time / dt),
            monitor_interval=round(300 / dt) if dt < 5 else 1))
        elastic = rows.elastic
        balance = rows["total"] + rows["damped"]
        common = np.abs((rows["time_fs"] + 1) % 300 - 1) < 1e-6
        return {"position": state.whole, "elastic": elastic[common, None] / elastic[0],
                "balance": (balance - balance[0]) / elastic[0]}

    # Segment length

    def length(self, setting):
        T = setting.length
        tip = self.elastica(T)
        exact = independent.elastica_tip(3.0, 20 * LENGTH)
        setting.error("cantilever", "elastica tip", np.hypot(*(tip - exact)))
        setting.error("free fibre", "bending frequency", self.frequency(T) - 1)
        energy = self.resting(setting.options, T)
        setting.error("two tubes", "corrugation", np.ptp(energy) / energy.min())
        setting.error("two tubes", "adhesion", energy.mean() / self.adhesion("smooth") - 1)
        setting.error("20 diameters", "share that breaks",
                      self.broken_share(T) - self.breaking_share())
        if T != 0.5 * LENGTH:
            setting.error("sparse tension", "stress at 5 %",
                          self.stress(T) / self.stress(0.5 * LENGTH) - 1)

    STRAIN, MEAN, DEVIATION, FIBRES = 0.02, 0.03, 0.005, 600

    def breaking_share(self):
        """Share of fibres of 20 diameters whose weakest place breaks at STRAIN."""
        below = 0.5 * math.erfc((self.MEAN - self.STRAIN) / self.DEVIATION / math.sqrt(2))
        return 1 - (1 - below)**20

    def broken_share(self, T):
        """The same from FIBRES fibres stretched at once: uncertain by 2 %."""
        bonds = round(20 * LENGTH / T)
        position = np.zeros((self.FIBRES, bonds + 1, 3))
        position[:, :, 0] = np.arange(bonds + 1) * T * (1 + self.STRAIN)
        position[:, :, 1] = 40.0 * np.arange(self.FIBRES)[:, None]
        file = self.own_file(f"stretched{T:g}.h5")
        q = rotations.no_rotation(bonds + 1)
        states.write(file, states.of_fibres([(fibre, q) for fibre in position], [-100] * 3,
                                            [500, 40 * self.FIBRES, 100]))
        state, _ = self.program.final({
            "scene": "file", "scene_file": file, "fibre_segment_length": T, "pair": "none",
            "ts_dt": 0.001, "ts_max_steps": 1, "energy_alarm": 0, "break_strain_mean": self.MEAN,
            "break_strain_std": self.DEVIATION})
        return state["bond_broken"].reshape(self.FIBRES, -1).any(axis=1).mean()

    def own_file(self, name):
        """A file that no run beside this one writes."""
        folder = self.folder / f"{threading.get_ident()}"
        folder.mkdir(exist_ok=True)
        return folder / name

    def stress(self, T):
        """Stress of a sparse weave at 5 %, GPa: the same piece, cut into segments of T."""
        file = self.own_file(f"stress{T:g}.csv")
        self.program.run({
            "scene": "weave", "weave_fibres": "4,4", "weave_segments": round(60 * LENGTH / T),
            "weave_pitch": 195,
            "fibre_segment_length": T, "damping_local": 0.4, "ts_dt": 20 * min(1, T / LENGTH)**2,
            "tension_rate": 4e-6, "tension_ends": "-15,795", "tension_width": 800,
            "tension_max_strain": 0.05, "monitor_interval": 20, "stress_monitor": f"ascii:{file}"})
        rows = tables.read(file)
        late = rows["strain"] > 0.04
        stress = 0.5 * (rows["stress_left_GPa"] + rows["stress_right_GPa"])
        return np.polyval(np.polyfit(rows["strain"][late], stress[late], 1), 0.05)

    def elastica(self, T, bonds=20 * LENGTH):
        """Tip of a cantilever at rest under P L^2/EJ = 3, over L."""
        n, load = round(bonds / T), 3 * independent.EJ / bonds**2
        limit = 48.37 * min(1.0, T / LENGTH)
        half = 0.1 * T
        state, _ = self.program.final({
            "scene": "fibre", "fibre_segments": n + 1, "fibre_segment_length": T, "pair": "none",
            "damping_local": 0.7, "ts_dt": 0.4 * limit * min(1.0, T / LENGTH),
            "ts_max_time": 2.5e6, "bc": "root,tip", "root_fix": "1,1,1", "root_fix_rotation": None,
            "root_region": f"{-half},-1,-1,{half},1,1",
            "tip_region": f"{bonds - half},-1,-1,{bonds + half},1,1", "tip_force": f"0,{load!r},0",
            "domain_lower": "-300,-300,-300", "domain_upper": "600,600,600"})
        return state.whole[-1, :2] / bonds

    def frequency(self, T, length=40 * LENGTH):
        """Measured over exact frequency of the first bending mode of a free fibre."""
        file = generators.free_mode(self.folder / f"mode{T:g}.h5", T, length, 0.2)
        exact = independent.free_beam_frequency(length, 640)
        dt = 10.0 * min(1.0, T / LENGTH)
        every = round(500 / dt)
        rows, _, _ = self.program.table({
            "scene": "file", "scene_file": file, "fibre_segment_length": T, "pair": "none",
            "ts_dt": dt, "ts_max_time": 2 * np.pi / exact, "monitor_interval": every})
        moving, t = rows.motion, rows["time_fs"]

        def misfit(ratio):
            wave = np.sin(ratio * exact * t)**2
            return np.sum((moving - wave * (moving @ wave) / (wave @ wave))**2)
        best, width = 1.0, 0.2
        for _ in range(8):
            tried = best + width * np.linspace(-1, 1, 41)
            best, width = tried[np.argmin([misfit(x) for x in tried])], 0.1 * width
        return best
