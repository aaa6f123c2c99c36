"""What docs/python.md promises of `import quern`. Run by ctest from the root of the repository."""
import gc
import pathlib
import sys
import tempfile
import unittest

root = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(root))
import numpy as np
import quern

TEXT = """
name = "small"
duration = "20 ms"
[material.steel]
density = 7800
young = "10 MPa"
[pair.default]
restitution = 0.5
[species.ball]
material = "steel"
diameter = "20 mm"
[mill]
type = "tumbling"
diameter = "0.2 m"
length = "0.1 m"
speed_fraction = 0.7
[insert.charge]
species = "ball"
count = 40
"""


class Module(unittest.TestCase):
    def test_arrays_are_views_of_the_present(self):
        mill = quern.Case(text=TEXT).simulation()
        first, again = mill.position, mill.position
        self.assertEqual(first.shape, (40, 3))
        self.assertEqual(first.__array_interface__["data"], again.__array_interface__["data"])
        self.assertFalse(first.flags.owndata or first.flags.writeable)
        before = first.copy()
        mill.step(50)
        self.assertEqual(first.__array_interface__["data"], mill.position.__array_interface__["data"])
        self.assertTrue(np.array_equal(first, mill.position))
        self.assertFalse(np.array_equal(first, before))
        with self.assertRaises(ValueError):
            first[0, 0] = 1

    def test_views_outlive_the_simulation(self):
        position = quern.Case(text=TEXT).simulation().position
        gc.collect()
        self.assertTrue(np.isfinite(position).all())

    def test_arrays_have_si_values(self):
        mill = quern.Case(text=TEXT).simulation()
        self.assertTrue(np.allclose(mill.radius, 0.01))
        self.assertTrue(np.allclose(mill.mass, 7800 * 4 / 3 * np.pi * 1e-6))
        self.assertTrue(np.allclose(mill.moment_of_inertia, 0.4 * mill.mass * 1e-4))
        self.assertEqual(sorted(mill.id), list(range(40)))
        self.assertEqual([mill.species_names[k] for k in set(mill.species)], ["ball"])

    def test_steps_in_pieces_or_at_once_give_the_same_bits_for_any_number_of_threads(self):
        one, other = quern.Case(text=TEXT).simulation(threads=1), quern.Case(text=TEXT).simulation(threads=2)
        one.run()
        while other.steps < one.steps:
            other.step(7 if one.steps - other.steps >= 7 else 1)
        self.assertTrue(np.array_equal(one.position, other.position))
        self.assertEqual(one.ledger, other.ledger)

    def test_the_ledger_closes(self):
        mill = quern.Case(text=TEXT, set={"duration": "0.3 s"}).simulation()
        mill.run()
        ledger = mill.ledger
        self.assertLess(abs(ledger["gap"]), 1e-3 * max(abs(ledger["wall_work"]), ledger["normal_loss"] + ledger["sliding_loss"]))

    def test_errors_are_the_sentences_of_the_program(self):
        case = quern.Case(text=TEXT)
        with self.assertRaisesRegex(quern.InputError, "mill.speed_fractoin is not a known key. The nearest known key is mill.speed_fraction"):
            case["mill.speed_fractoin"] = 0.8
        with self.assertRaisesRegex(quern.InputError, "duration"):
            case["duration"] = "-1 s"
        self.assertEqual(case.duration, 0.02)  # as it was
        with self.assertRaisesRegex(quern.InputError, "nowhere.toml: there is no such file"):
            quern.Case("nowhere.toml")
        with self.assertRaisesRegex(quern.InputError, "text:5: material.steel.density"):
            quern.Case(text=TEXT.replace("7800", '"heavy"'))
        self.assertTrue(issubclass(quern.InputError, ValueError) and issubclass(quern.RunError, RuntimeError))
        with self.assertRaises(TypeError):
            quern.Case()
        with tempfile.TemporaryDirectory() as folder, self.assertRaisesRegex(quern.InputError, "no run to go on with"):
            case.run(folder + "/none", resume=True)

    def test_a_case_is_written_with_its_files_and_read_again(self):
        case = quern.Case(text=TEXT, set={"seed": 3})
        with tempfile.TemporaryDirectory() as folder:
            case.write(folder + "/case.toml")
            # What was a default is then given.
            self.assertEqual(quern.Case(folder + "/case.toml").text, case.text.replace(" (default)", ""))

    def test_the_keys_are_those_of_the_reference(self):
        page = (root / "docs/case-reference.md").read_text()
        for key in quern.keys():
            self.assertIn(f"| `{key['path'].split('.')[-1]}` |", page)


if __name__ == "__main__":
    unittest.main()
