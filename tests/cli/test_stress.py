#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The stress that the tools make of a sample file is the program's, in broken tetrahedra too."""
from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.dont_write_bytecode = True
sys.path[:0] = [str(ROOT / "tools")]

import command_lines  # noqa: E402
from crackle_launch import environment  # noqa: E402
from crackle_report.reading import SampleFiles  # noqa: E402
from crackle_report.stress import ALL_EDGES, element_stress, frame_stresses  # noqa: E402

PROGRAM = FRAME_STRESSES = ""
PLATE = (ROOT / "tests" / "support" / "plate.toml").read_text(encoding="utf-8").replace("frames = 4", "frames = 13")
# Quickly loaded from rest, and less as time goes on, so that what has opened closes again.
STRUCK = (PLATE.replace("[time]", '[time]\nstart = "rest"')
          .replace('force = ["0 N", "0 N", "100 N"]', 'force = ["0 N", "0 N", "650 N"]')
          .replace('rate = ["0 N/s", "0 N/s", "5 N/s"]', 'rate = ["0 N/s", "0 N/s", "-8e7 N/s"]'))


def with_release(text: str, release: str, contact: str = "none") -> str:
    return text.replace("[fracture]", f'[fracture]\nrelease = "{release}"\ncontact = "{contact}"')


class Stress(unittest.TestCase):
    def sample(self, text: str):
        """Frames and energies of a sample, and the stresses that the program has at the frames."""
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name) / "out"
            (Path(name) / "plate.toml").write_text(text, encoding="utf-8")
            command_lines.crackle(PROGRAM, "sample", Path(name) / "plate.toml", "--sample", 1, "-o", folder).check_returncode()
            files = SampleFiles(folder)
            frames, energy = files.frames(1), files.energy(1)
            output = subprocess.run([FRAME_STRESSES, str(folder / "samples" / "0001.h5")], env=environment(),
                                    stdout=subprocess.PIPE, check=True).stdout
        return frames, energy, np.frombuffer(output).reshape(frames.time.size, len(frames.tetrahedra), 6)

    def compare(self, name: str, text: str, energy_bound: float = 1e-6):
        """@return the frames; for each, the size of its broken tetrahedra's stress [Pa]; the largest share of strain
        energy that broken tetrahedra have"""
        frames, energy, expected = self.sample(text)
        young, poisson = frames.youngs_modulus, frames.poisson_ratio
        corner = frames.nodes[frames.tetrahedra]
        volume = np.linalg.det(corner[:, 1:] - corner[:, :1]) / 6
        worst, worst_energy, carried, share = 0.0, 0.0, [], 0.0
        for k, stress in enumerate(frame_stresses(frames)):
            self.assertTrue(np.isfinite(stress).all())
            intact = element_stress(frames.nodes, frames.tetrahedra, frames.displacement[k], young, poisson)
            difference, size, unbroken = (np.linalg.norm(s, axis=1) for s in (stress - expected[k], expected[k], intact))
            # 1 Pa beside those of megapascals, for what is at rest or carries nothing.
            worst = max(worst, (difference / np.maximum(size, np.maximum(1e-6 * unbroken, 1.0))).max())
            carried.append(np.linalg.norm(stress[frames.broken[k]], axis=1))
            # Half of stress times strain; strain = E^-1 of the intact stress.
            trace = intact[:, :3].sum(axis=1, keepdims=True)
            strain = ((1 + poisson) / young)[:, None] * intact
            strain[:, :3] -= (poisson / young)[:, None] * trace
            strain -= frames.initial_strain
            strain_energy = (stress * strain * (1, 1, 1, 2, 2, 2)).sum(axis=1) * volume / 2
            row = np.flatnonzero(energy.time == frames.time[k])[0]
            worst_energy = max(worst_energy, abs(strain_energy.sum() - energy.strain[row]) / energy.strain.max())
            share = max(share, strain_energy[frames.broken[k]].sum() / energy.strain.max())
        print(f"{name}: {frames.broken[-1].size} tetrahedra broken; largest difference of a stress {worst:.1e}, of the strain "
              f"energy {worst_energy:.1e}; broken tetrahedra have up to {share:.1e} of it")
        self.assertLess(worst, 1e-9)
        self.assertLess(worst_energy, energy_bound)  # displacements are stored in single precision
        return frames, carried, share

    def test_release_by_elements_leaves_nothing(self):
        frames, carried, _ = self.compare("element", with_release(PLATE, "element"))
        self.assertGreater(frames.broken[-1].size, 20)
        self.assertEqual(max(values.max(initial=0) for values in carried), 0)

    def test_release_by_facets_leaves_what_uncut_edges_carry(self):
        n_edges = np.array([bin(edges).count("1") for edges in range(ALL_EDGES + 1)])
        n_released, n_grown, largest_share = set(), 0, 0.0
        for name, text in (("facet", PLATE), ("facet, from rest", STRUCK)):
            frames, _, share = self.compare(name, with_release(text, "facet"))
            for released in frames.released:
                n_released.update(n_edges[released].tolist())
            largest_share = max(largest_share, share)
            # Later frames have the same edges released of the same tetrahedra, and more.
            pairs = [(one, later[:one.size]) for one, later in zip(frames.released, frames.released[1:])]
            self.assertTrue(all((one & later == one).all() for one, later in pairs))
            n_grown += sum(np.count_nonzero(one != later) for one, later in pairs)
        self.assertEqual(n_released, {3, 4, 5, 6})
        self.assertGreater(n_grown, 0)
        self.assertGreater(largest_share, 1e-2)

    def test_softened_tetrahedra_carry_their_share(self):
        text = with_release(PLATE, "softening").replace("[fracture]", '[fracture]\ntoughness = "1500 J/m^2"')
        frames, _, _ = self.compare("softening", text)
        left = frames.stiffness[-1]
        self.assertGreater(np.count_nonzero(left < 1), 20)
        self.assertEqual(np.count_nonzero(frames.stiffness[0] < left), 0)

    def test_release_in_time_leaves_what_has_not_fallen_yet(self):
        for release in ("element", "facet"):
            text = with_release(PLATE, release).replace("[fracture]", '[fracture]\nrelease_time = "4 us"')
            # The program's share is the mean over the coming step, which is some 1 % of the time.
            frames, _, share = self.compare(f"{release}, in time", text, 5e-3)
            self.assertGreater(sum(np.count_nonzero((left > 0) & (left < 1)) for left in frames.remaining), 10)
            self.assertGreater(share, 1e-3)

    def test_stiffness_varies_from_tetrahedron_to_tetrahedron(self):
        variation = '[material.variation]\ndistribution = "lognormal"\ncoefficient_of_variation = 0.3\n\n'
        for release in ("element", "facet"):
            text = with_release(PLATE, release).replace("[fracture]", variation + "[fracture]", 1)
            text = text.replace('"100 N"', '"50 N"')  # the weakest breaks before 100 N
            frames, _, _ = self.compare(f"{release}, varying stiffness", text)
            self.assertGreater(np.std(frames.youngs_modulus), 0.25 * np.mean(frames.youngs_modulus))

    def test_stress_from_the_start_adds_up(self):
        stress = '[[initial.stress]]\nalong = "x"\nsurface = "-3 MPa"\nhistory = [["0 s", 1], ["100 s", 2]]\n\n'
        for release in ("element", "facet"):
            frames, _, _ = self.compare(f"{release}, initial stress", with_release(PLATE, release).replace("[fracture]", stress + "[fracture]", 1))
            self.assertGreater(abs(frames.initial_strain[:, 1]).max(), 4e-4)

    def test_contact_carries_while_closed(self):
        for release in ("element", "facet"):
            # Frames do not know the springs between surfaces, nor which cuts have been apart before.
            _, carried, share = self.compare(f"{release} with contact", with_release(STRUCK, release, "frictionless"), 0.3)
            self.assertGreater(share, 1e-4)
            if release == "element":
                self.assertGreater(np.count_nonzero(carried[-1]), 0)
                self.assertGreater(np.count_nonzero(carried[-1] == 0), 0)


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--program", required=True)
    parser.add_argument("--frame-stresses", required=True)
    options, rest = parser.parse_known_args()
    PROGRAM, FRAME_STRESSES = options.program, options.frame_stresses
    unittest.main(argv=[sys.argv[0], *rest], verbosity=2)
