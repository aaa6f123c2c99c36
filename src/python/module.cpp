// The bindings; what a user sees of them is quern/__init__.py.
#include <pybind11/functional.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include "src/base/error.hpp"
#include "src/case/case.hpp"
#include "src/case/keys.hpp"
#include "src/case/reference.hpp"
#include "src/case/values.hpp"
#include "src/output/ledger_table.hpp"
#include "src/python/session.hpp"

namespace py = pybind11;

namespace quern {
namespace {

// A case as read, and what it was read from.
struct ReadCase {
  Values values;
  Case read;
  explicit ReadCase(Values v) : values(std::move(v)), read(named_case_of(values)) {}
};

// A view of memory that `owner` keeps: nothing is copied, and nothing can be written.
template <class T>
py::array view(const T* first, const std::vector<py::ssize_t>& shape, const std::vector<py::ssize_t>& strides, const py::object& owner) {
  py::array seen(py::dtype::of<T>(), shape, strides, first, owner);
  py::detail::array_proxy(seen.ptr())->flags &= ~py::detail::npy_api::NPY_ARRAY_WRITEABLE_;
  return seen;
}

// Of the rows of all particles: n × 3 (places, velocities …), or the companion of each.
py::array triples(const std::vector<Quad>& rows, const py::object& owner) {
  return view(&rows.data()->x, {static_cast<py::ssize_t>(rows.size()), 3}, {sizeof(Quad), sizeof(double)}, owner);
}
py::array companions(const std::vector<Quad>& rows, const py::object& owner) {
  return view(&rows.data()->w, {static_cast<py::ssize_t>(rows.size())}, {sizeof(Quad)}, owner);
}
template <class T>
py::array numbers(const std::vector<T>& values, const py::object& owner) {
  return view(values.data(), {static_cast<py::ssize_t>(values.size())}, {sizeof(T)}, owner);
}

using Self = const py::object&;
const Particles& particles_of(Self self) { return self.cast<const Session&>().simulation().particles; }

// ^C during long work: Python's own handler tells.
void let_python_in() {
  const py::gil_scoped_acquire held;
  if (PyErr_CheckSignals() != 0) throw py::error_already_set();
}

py::tuple table_of(const Table& table) {
  py::dict columns, units;
  for (const Column& column : table.columns) {
    if (column.labels.empty()) columns[py::str(column.name)] = py::array_t<double>(static_cast<py::ssize_t>(column.values.size()), column.values.data());
    else columns[py::str(column.name)] = py::cast(column.labels);
    units[py::str(column.name)] = column.unit;
  }
  return py::make_tuple(columns, units, table.description);
}

py::dict dict_of(const std::vector<Headline>& headlines) {
  py::dict all;
  for (const Headline& one : headlines) {
    py::dict entry;
    entry["value"] = one.value, entry["unit"] = one.unit, entry["description"] = one.description;
    if (one.ci95) entry["ci95"] = py::cast(*one.ci95);
    all[py::str(one.key)] = entry;
  }
  return all;
}

py::dict ledger_of(const Session& session) {
  Table table = empty_ledger_table();
  append_row(table, 0, session.ledger());
  py::dict entries;
  for (const Column& column : table.columns)
    if (column.name != "time") entries[py::str(column.name)] = column.values.front();
  return entries;
}

std::vector<std::string> names_of(const auto& list) {
  std::vector<std::string> names;
  for (const auto& one : list) names.push_back(one.name);
  return names;
}

py::dict dict_of(const Key& key) {
  py::dict entry;
  entry["path"] = key.path, entry["unit"] = key.unit, entry["default"] = key.fallback, entry["allowed"] = allowed_by(key), entry["meaning"] = key.meaning, entry["source"] = key.source;
  return entry;
}

}  // namespace
}  // namespace quern

PYBIND11_MODULE(_quern, m) {
  using namespace quern;
  py::register_exception<InputError>(m, "InputError", PyExc_ValueError);
  py::register_exception<RunError>(m, "RunError", PyExc_RuntimeError);

  py::class_<ReadCase>(m, "ReadCase")
      .def_static("of_file", [](const std::string& file, const std::vector<std::string>& overrides) { return ReadCase(read_values(file, overrides)); })
      .def_static("of_text", [](const std::string& text, const std::string& file, const std::vector<std::string>& overrides) { return ReadCase(read_values_in(text, file, overrides)); })
      .def_property_readonly("name", [](const ReadCase& c) { return c.read.name; })
      .def_property_readonly("title", [](const ReadCase& c) { return c.read.title; })
      .def_property_readonly("duration", [](const ReadCase& c) { return c.read.duration; })
      .def_property_readonly("text", [](const ReadCase& c) { return c.read.text; })
      .def_property_readonly("warnings", [](const ReadCase& c) { return c.read.warnings; })
      .def("write", [](const ReadCase& c, const std::string& file) {
        Values named = c.values;
        if (!named.has("name")) named.put("name", c.read.name, "its file");
        write_echo(file, "", named);
      });

  const auto stepping = py::call_guard<py::gil_scoped_release>();
  py::class_<Session>(m, "Session")
      .def(py::init([](const ReadCase& c, int threads) { return std::make_unique<Session>(c.read, threads); }), stepping)
      .def("step", [](Session& s, std::int64_t steps) { s.step(steps, let_python_in); }, stepping)
      .def("run_until", [](Session& s, double time) { s.run_until(time, let_python_in); }, stepping)
      .def_property_readonly("duration", &Session::duration)
      .def_property_readonly("time", [](const Session& s) { return s.simulation().clock.time(); })
      .def_property_readonly("steps", [](const Session& s) { return s.simulation().clock.step; })
      .def_property_readonly("time_step", [](const Session& s) { return s.simulation().clock.time_step; })
      .def_property_readonly("position", [](Self self) { return triples(particles_of(self).position, self); })
      .def_property_readonly("radius", [](Self self) { return companions(particles_of(self).position, self); })
      .def_property_readonly("velocity", [](Self self) { return triples(particles_of(self).velocity, self); })
      .def_property_readonly("mass", [](Self self) { return companions(particles_of(self).velocity, self); })
      .def_property_readonly("spin", [](Self self) { return triples(particles_of(self).spin, self); })
      .def_property_readonly("moment_of_inertia", [](Self self) { return companions(particles_of(self).spin, self); })
      .def_property_readonly("acceleration", [](Self self) { return triples(particles_of(self).acceleration, self); })
      .def_property_readonly("orientation", [](Self self) {
        const std::vector<Quad>& rows = particles_of(self).orientation;
        return view(&rows.data()->x, {static_cast<py::ssize_t>(rows.size()), 4}, {sizeof(Quad), sizeof(double)}, self);
      })
      .def_property_readonly("id", [](Self self) { return numbers(particles_of(self).id, self); })
      .def_property_readonly("species", [](Self self) { return numbers(particles_of(self).species, self); })
      .def_property_readonly("material", [](Self self) { return numbers(particles_of(self).material, self); })
      .def_property_readonly("species_names", [](const Session& s) { return names_of(s.simulation().species); })
      .def_property_readonly("material_names", [](const Session& s) { return names_of(s.simulation().materials); })
      .def_property_readonly("walls", [](const Session& s) {
        py::dict walls;
        for (const Wall& wall : s.simulation().walls) {
          py::dict entry;
          entry["force"] = py::make_tuple(wall.force.x, wall.force.y, wall.force.z);
          entry["torque"] = py::make_tuple(wall.torque.x, wall.torque.y, wall.torque.z);
          walls[py::str(wall.name)] = entry;
        }
        return walls;
      })
      .def_property_readonly("warnings", &Session::warnings)
      .def_property_readonly("ledger", ledger_of)
      .def("tables", [](Session& s) {
        py::dict all;
        for (const Table& table : s.tables()) all[py::str(table.name)] = table_of(table);
        return all;
      })
      .def("headlines", [](Session& s) { return dict_of(s.headlines()); });

  m.def("keys", [] {
    py::list all;
    for (const Key& key : all_keys()) all.append(dict_of(key));
    return all;
  });
}
