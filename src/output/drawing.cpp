#include "src/output/drawing.hpp"
#include <fmt/format.h>
#include <unistd.h>
#include <vtkActor.h>
#include <vtkAutoInit.h>
#include <vtkAxis.h>
#include <vtkBrush.h>
#include <vtkCamera.h>
#include <vtkCellArray.h>
#include <vtkChartLegend.h>
#include <vtkChartXY.h>
#include <vtkColorTransferFunction.h>
#include <vtkContextActor.h>
#include <vtkContextScene.h>
#include <vtkCoordinate.h>
#include <vtkDoubleArray.h>
#include <vtkFloatArray.h>
#include <vtkImageShrink3D.h>
#include <vtkLight.h>
#include <vtkNew.h>
#include <vtkOpenGLSphereMapper.h>
#include <vtkPNGWriter.h>
#include <vtkPen.h>
#include <vtkPlot.h>
#include <vtkPlotFunctionalBag.h>
#include <vtkPlotPoints.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkScalarBarActor.h>
#include <vtkSmartPointer.h>
#include <vtkStringArray.h>
#include <vtkTable.h>
#include <vtkTextActor.h>
#include <vtkTextProperty.h>
#include <vtkUnsignedCharArray.h>
#include <vtkWindowToImageFilter.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include "bonds/fragments.hpp"
#include "src/base/error.hpp"
#include "src/base/whole_file.hpp"
#include "src/output/axis_scale.hpp"
#include "src/output/palette.hpp"
#include "src/output/shape_surfaces.hpp"
#include "src/output/wall_facets.hpp"

VTK_MODULE_INIT(vtkRenderingOpenGL2)
VTK_MODULE_INIT(vtkRenderingFreeType)
VTK_MODULE_INIT(vtkRenderingContextOpenGL2)

namespace quern {
namespace {

constexpr int width = 1200, height = 900;
// Drawn so many times larger and then shrunk: smooth edges also of spheres, which multisampling does not reach.
constexpr int finer = 2;
constexpr Colour ink{0.13, 0.13, 0.15}, steel{0.62, 0.64, 0.67};

// VTK's own Arial has no superscripts; DejaVu comes with Debian's fontconfig.
constexpr const char *font_file = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf",
                     *bold_font_file = "/usr/share/fonts/truetype/dejavu/DejaVuSans-Bold.ttf";
bool has_font() { return access(font_file, R_OK) == 0 && access(bold_font_file, R_OK) == 0; }

void set_type(vtkTextProperty* text, int size, bool bold = false) {
  if (has_font()) {
    text->SetFontFamily(VTK_FONT_FILE);
    text->SetFontFile(bold ? bold_font_file : font_file);
    text->BoldOff();
  } else {
    text->SetFontFamilyToArial();
    text->SetBold(bold);
  }
  text->ItalicOff();
  text->ShadowOff();
  text->SetFontSize(finer * size);
  text->SetColor(ink[0], ink[1], ink[2]);
}

void render(vtkRenderer* renderer, const std::string& path) {
  vtkNew<vtkRenderWindow> window;
  window->SetOffScreenRendering(1);
  window->SetMultiSamples(0);
  window->SetSize(finer * width, finer * height);
  window->AddRenderer(renderer);
  window->Render();
  vtkNew<vtkWindowToImageFilter> shot;
  shot->SetInput(window);
  shot->SetInputBufferTypeToRGB();
  shot->ReadFrontBufferOff();
  vtkNew<vtkImageShrink3D> smaller;
  smaller->SetInputConnection(shot->GetOutputPort());
  smaller->SetShrinkFactors(finer, finer, 1);
  smaller->MeanOn();
  vtkNew<vtkPNGWriter> writer;
  writer->WriteToMemoryOn();
  writer->SetInputConnection(smaller->GetOutputPort());
  writer->Write();
  vtkUnsignedCharArray* picture = writer->GetResult();
  const auto size = static_cast<std::size_t>(picture->GetNumberOfValues());
  write_whole_file(path, std::string_view(reinterpret_cast<const char*>(picture->GetPointer(0)), size));
}

// Viridis (van der Walt & Smith 2015), nine of its colours.
vtkSmartPointer<vtkColorTransferFunction> speed_colours(double most) {
  constexpr std::array<Colour, 9> viridis{{{0.267, 0.005, 0.329}, {0.279, 0.175, 0.483}, {0.230, 0.322, 0.546}, {0.173, 0.449, 0.558},
                                           {0.128, 0.567, 0.551}, {0.158, 0.684, 0.502}, {0.369, 0.789, 0.383}, {0.678, 0.864, 0.190},
                                           {0.993, 0.906, 0.144}}};
  auto colours = vtkSmartPointer<vtkColorTransferFunction>::New();
  for (std::size_t k = 0; k < viridis.size(); ++k) {
    colours->AddRGBPoint(most * static_cast<double>(k) / (viridis.size() - 1), viridis[k][0], viridis[k][1], viridis[k][2]);
  }
  return colours;
}

// The end of a scale from zero that holds a value, and into how many even parts it is cut.
struct RoundScale {
  double most;
  int parts;
};
RoundScale round_scale(double value) {
  const double decade = std::pow(10.0, std::floor(std::log10(value)));
  for (const auto& [most, parts] : {std::pair(1.0, 5), {1.5, 3}, {2.0, 4}, {2.5, 5}, {3.0, 3}, {4.0, 4}, {5.0, 5}, {6.0, 3}, {8.0, 4}})
    if (value <= most * decade * (1 + 1e-9)) return {most * decade, parts};
  return {10 * decade, 5};
}

vtkSmartPointer<vtkActor> surface_of(const Facets& facets, const Colour& colour, double opacity) {
  vtkNew<vtkPoints> points;
  for (const Vec3& p : facets.points) points->InsertNextPoint(p.data());
  vtkNew<vtkCellArray> triangles;
  for (const auto& t : facets.triangles) triangles->InsertNextCell({t[0], t[1], t[2]});
  vtkNew<vtkPolyData> data;
  data->SetPoints(points);
  data->SetPolys(triangles);
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(data);
  auto actor = vtkSmartPointer<vtkActor>::New();
  actor->SetMapper(mapper);
  actor->GetProperty()->SetColor(colour[0], colour[1], colour[2]);
  actor->GetProperty()->SetOpacity(opacity);
  actor->GetProperty()->SetAmbient(0.35);
  actor->GetProperty()->SetDiffuse(0.65);
  return actor;
}

// The view's own axes: right, up, towards the viewer.
struct View {
  Vec3 right, up, towards;
};

View view_along(const Vec3& axis, const Vec3& gravity) {
  Vec3 up = -gravity + axis * gravity.dot(axis);
  if (gravity.isZero()) up = Vec3::UnitZ() - axis * axis.z();  // as it is drawn where nothing falls
  if (up.norm() < 1e-9 * (1 + gravity.norm())) up = axis.unitOrthogonal();
  up.normalize();
  return {up.cross(axis), up, axis};
}

// The cut through a jacket, thick enough to be seen: a ring across the view, at its end towards the viewer.
Facets ring_of(const Vec3& centre, const View& view, double inner, double outer) {
  Facets ring;
  constexpr int around = 360;
  for (Index k = 0; k < around; ++k) {
    const double angle = 2 * std::numbers::pi * k / around;
    const Vec3 out = std::cos(angle) * view.right + std::sin(angle) * view.up;
    ring.points.push_back(centre + inner * out);
    ring.points.push_back(centre + outer * out);
    const Index a = 2 * k, b = a + 1, c = 2 * ((k + 1) % around), d = c + 1;
    ring.triangles.push_back({a, b, d});
    ring.triangles.push_back({a, d, c});
  }
  return ring;
}

void add_walls(vtkRenderer* renderer, const Simulation& s, const View& view, const Surroundings& shown) {
  for (const Wall& wall : s.walls) {
    const Revolved* revolved = std::get_if<Revolved>(&wall.surface);
    const bool along_view = revolved && std::abs(wall.pose.axes.col(2).dot(view.towards)) > 1 - 1e-6;
    if (along_view && revolved->z_0 == revolved->z_1) continue;  // an end wall would hide what is behind it
    if (along_view && revolved->radius_0 == revolved->radius_1) {
      const double z = (wall.pose.axes.col(2).dot(view.towards) > 0) == (revolved->z_1 > revolved->z_0) ? revolved->z_1 : revolved->z_0;
      const double r = revolved->radius_0, thick = 0.035 * r;
      const bool holds = revolved->side != Revolved::Side::outside;
      auto ring = surface_of(ring_of(wall.pose.to_fixed({0, 0, z}), view, holds ? r : r - thick, holds ? r + thick : r), steel, 1.0);
      ring->GetProperty()->LightingOff();
      renderer->AddActor(ring);
      continue;
    }
    // Meshes stand as they are, so that lifters show; what else there is lets the particles shine through.
    const bool mesh = std::holds_alternative<Mesh>(wall.surface);
    auto actor = surface_of(facets_of(wall, shown, 180), steel, mesh ? 1.0 : 0.18);
    if (mesh) actor->GetProperty()->SetAmbient(0.75), actor->GetProperty()->SetDiffuse(0.25);
    renderer->AddActor(actor);
  }
}

// Points of `particles` (rows), in a colour of each row's own, or by speed where none is given.
void add_coloured(vtkRenderer* renderer, vtkPolyData* data, vtkPolyDataMapper* mapper, const Particles& p, const std::vector<std::size_t>& particles,
                  vtkColorTransferFunction* colours, const std::vector<Colour>& own) {
  if (own.empty()) {
    vtkNew<vtkFloatArray> speed;
    speed->SetName("speed");
    for (const std::size_t k : particles) speed->InsertNextValue(static_cast<float>(length(xyz(p.velocity[k]))));
    data->GetPointData()->SetScalars(speed);
    mapper->SetLookupTable(colours);
    mapper->UseLookupTableScalarRangeOn();
  } else {
    vtkNew<vtkUnsignedCharArray> paint;
    paint->SetName("colour");
    paint->SetNumberOfComponents(3);
    for (const std::size_t k : particles) paint->InsertNextTuple3(255 * own[k][0], 255 * own[k][1], 255 * own[k][2]);
    data->GetPointData()->SetScalars(paint);
    mapper->SetColorModeToDirectScalars();
  }
  mapper->SetInputData(data);
  mapper->InterpolateScalarsBeforeMappingOff();
  vtkNew<vtkActor> actor;
  actor->SetMapper(mapper);
  actor->GetProperty()->SetAmbient(0.22);
  actor->GetProperty()->SetDiffuse(0.80);
  actor->GetProperty()->SetSpecular(0.30);
  actor->GetProperty()->SetSpecularPower(40);
  renderer->AddActor(actor);
}

// One colour for each particle, or none: then by speed.
// `towards`: of the particles no more is shown than those that lie behind their middle in this direction; zero: all.
void add_particles(vtkRenderer* renderer, const Simulation& s, const Vec3& towards, vtkColorTransferFunction* colours, const std::vector<Colour>& own = {}) {
  const Particles& p = s.particles;
  Vec3 middle = Vec3::Zero();
  for (Index i = 0; i < p.owned; ++i) middle += vec(p.position[static_cast<std::size_t>(i)]) / p.owned;
  const auto shown = [&](std::size_t k) {
    const Quad &x = p.position[k], &v = p.velocity[k];
    return std::isfinite(x.x + x.y + x.z + v.x + v.y + v.z) && !((vec(x) - middle).dot(towards) > 0);
  };
  vtkNew<vtkPoints> points;
  vtkNew<vtkFloatArray> radius;
  radius->SetName("radius");
  vtkNew<vtkCellArray> vertices;
  std::vector<std::size_t> spheres;
  for (Index i = 0; i < p.owned; ++i) {
    const auto k = static_cast<std::size_t>(i);
    if ((!p.shape.empty() && p.shape[k] != 0) || !shown(k)) continue;
    const Quad& x = p.position[k];
    const vtkIdType row = points->InsertNextPoint(x.x, x.y, x.z);
    radius->InsertNextValue(static_cast<float>(x.w));
    vertices->InsertNextCell(1, &row);
    spheres.push_back(k);
  }
  vtkNew<vtkPolyData> data;
  data->SetPoints(points);
  data->SetVerts(vertices);
  data->GetPointData()->AddArray(radius);
  vtkNew<vtkOpenGLSphereMapper> mapper;
  mapper->SetScaleArray("radius");
  if (!spheres.empty()) add_coloured(renderer, data, mapper, p, spheres, colours, own);
  if (p.shape.empty()) return;
  // Fine enough to look smooth, coarser where there are so many that each is small.
  constexpr double most_triangles = 5e6;
  const int cells = std::clamp(static_cast<int>(std::sqrt(most_triangles / (12.0 * std::max(1, p.owned)))), 4, 16);
  const ShapeSurfaces surfaces = shape_surfaces(s, cells, shown);
  vtkNew<vtkPoints> corners;
  vtkNew<vtkFloatArray> normals;
  normals->SetNumberOfComponents(3);
  for (const Vec3& point : surfaces.points) corners->InsertNextPoint(point.data());
  for (const Vec3& normal : surfaces.normals) normals->InsertNextTuple(normal.data());
  vtkNew<vtkCellArray> triangles;
  for (const auto& t : surfaces.triangles) triangles->InsertNextCell({t[0], t[1], t[2]});
  vtkNew<vtkPolyData> shapes;
  shapes->SetPoints(corners);
  shapes->SetPolys(triangles);
  shapes->GetPointData()->SetNormals(normals);
  vtkNew<vtkPolyDataMapper> surface;
  add_coloured(renderer, shapes, surface, p, surfaces.particle, colours, own);
}

void add_light(vtkRenderer* renderer, double x, double y, double z, double strength) {
  vtkNew<vtkLight> light;
  light->SetLightTypeToCameraLight();
  light->SetPosition(x, y, z);
  light->SetFocalPoint(0, 0, 0);
  light->SetIntensity(strength);
  renderer->AddLight(light);
}

// Centred at (x, y) of the picture, in pixels from its lower left corner.
vtkSmartPointer<vtkTextActor> add_text(vtkRenderer* renderer, const std::string& words, double x, double y, int size, bool bold = false) {
  auto text = vtkSmartPointer<vtkTextActor>::New();
  if (words.empty()) return text;
  text->SetInput(words.c_str());
  set_type(text->GetTextProperty(), size, bold);
  text->GetTextProperty()->SetJustificationToCentered();
  text->GetTextProperty()->SetVerticalJustificationToCentered();
  text->SetPosition(finer * x, finer * y);
  renderer->AddActor2D(text);
  return text;
}

// A title or caption across the picture, in smaller type where it would not fit.
void add_line_of_text(vtkRenderer* renderer, const std::string& words, double y, int size, bool bold) {
  const auto letters = std::count_if(words.begin(), words.end(), [](char c) { return (c & 0xC0) != 0x80; });
  const int fitting = static_cast<int>(0.95 * width / ((bold ? 0.68 : 0.60) * static_cast<double>(std::max<std::ptrdiff_t>(letters, 1))));
  add_text(renderer, words, 0.5 * width, y, std::min(size, fitting), bold);
}

RoundScale speed_scale(const Particles& p) {
  // The 99.5th percentile, so that one fast ball does not darken all the others.
  std::vector<double> speeds;
  for (Index i = 0; i < p.owned; ++i) {
    const double v = length(xyz(p.velocity[static_cast<std::size_t>(i)]));
    if (std::isfinite(v)) speeds.push_back(v);
  }
  if (speeds.empty()) return {1, 5};
  std::sort(speeds.begin(), speeds.end());
  const double high = speeds[static_cast<std::size_t>(0.995 * static_cast<double>(speeds.size() - 1))];
  return high > 1e-12 ? round_scale(high) : RoundScale{1, 5};
}

void add_speed_scale(vtkRenderer* renderer, vtkColorTransferFunction* colours, const RoundScale& speeds) {
  vtkNew<vtkScalarBarActor> scale;
  scale->SetLookupTable(colours);
  scale->SetNumberOfLabels(speeds.parts + 1);
  scale->SetUnconstrainedFontSize(true);
  scale->SetLabelFormat("%.3g");
  scale->SetBarRatio(0.28);
  scale->SetPosition(0.855, 0.22);
  scale->SetWidth(0.085);
  scale->SetHeight(0.52);
  scale->DrawFrameOff();
  set_type(scale->GetLabelTextProperty(), 20);
  renderer->AddActor2D(scale);
  add_text(renderer, "speed [m/s]", 1085, 700, 22);
}

// The heaviest fragments have a colour each. Further ones of several grains take turns with a few paler ones.
constexpr std::array<Colour, 10> fragment_palette{{{0.00, 0.45, 0.70}, {0.90, 0.62, 0.00}, {0.00, 0.62, 0.45}, {0.84, 0.37, 0.00}, {0.34, 0.71, 0.91},
                                                   {0.80, 0.47, 0.65}, {0.94, 0.89, 0.26}, {0.45, 0.30, 0.65}, {0.55, 0.27, 0.07}, {0.10, 0.25, 0.45}}};
constexpr std::array<Colour, 4> small_palette{{{0.80, 0.72, 0.60}, {0.66, 0.78, 0.70}, {0.84, 0.70, 0.72}, {0.70, 0.72, 0.82}}};
constexpr Colour single_grain{0.78, 0.78, 0.79}, no_grain{0.42, 0.44, 0.47};

Colour colour_of_fragment(const Fragments& fragments, std::size_t k) {
  if (fragments.list[k].grains == 1) return single_grain;
  return k < fragment_palette.size() ? fragment_palette[k] : small_palette[k % small_palette.size()];
}

// Of each row.
std::vector<Colour> colours_of(const Fragments& fragments, const Particles& p) {
  std::vector<Colour> colours(static_cast<std::size_t>(p.owned), no_grain);
  for (std::size_t i = 0; i < colours.size() && i < fragments.of_row.size(); ++i)
    if (fragments.of_row[i] >= 0) colours[i] = colour_of_fragment(fragments, static_cast<std::size_t>(fragments.of_row[i]));
  return colours;
}

// Right of the drawing: what part of the mass the fragments of each colour have.
void add_fragment_legend(vtkRenderer* renderer, const Fragments& fragments) {
  double y = 740;
  add_text(renderer, "fragments by mass", 1085, y, 20);
  const auto line = [&](const std::string& words, const Colour& colour) {
    y -= 34;
    add_text(renderer, "●", 995, y, 26)->GetTextProperty()->SetColor(colour[0], colour[1], colour[2]);
    add_text(renderer, words, 1018, y, 18)->GetTextProperty()->SetJustificationToLeft();
  };
  const auto percent = [&](double mass) { return fmt::format("{:.3g} %", 100 * mass / fragments.mass); };
  double small = 0, single = 0;
  std::size_t of_small = 0;
  for (std::size_t k = 0; k < fragments.list.size(); ++k) {
    const Fragment& f = fragments.list[k];
    if (f.grains == 1)
      single += f.mass;
    else if (k < fragment_palette.size())
      line(percent(f.mass), fragment_palette[k]);
    else
      small += f.mass, ++of_small;
  }
  if (of_small > 0) line(fmt::format("{}: {}", of_small == 1 ? "1 more" : fmt::format("{} more", of_small), percent(small)), small_palette[0]);
  if (single > 0) line("single: " + percent(single), single_grain);
}

}  // namespace

void draw_charge(const ChargePicture& picture, const std::string& path) {
  const Simulation& s = *picture.simulation;
  const View view = view_along(picture.axis, picture.up.isZero() ? s.gravity : (-picture.up).eval());
  const Surroundings shown = surroundings(s.walls, s.particles.position);

  vtkNew<vtkRenderer> renderer;
  renderer->SetBackground(1, 1, 1);
  renderer->AutomaticLightCreationOff();
  add_light(renderer, -0.6, 0.8, 1.0, 0.85);
  add_light(renderer, 0.8, 0.1, 0.7, 0.30);
  add_walls(renderer, s, view, shown);
  const Vec3 cut = picture.cut_open ? view.towards : Vec3::Zero().eval();
  const bool by_fragment = picture.by_fragment && !s.bonds.empty();
  const RoundScale speeds = speed_scale(s.particles);
  const auto colours = speed_colours(speeds.most);
  if (by_fragment) {
    const Fragments fragments = find_fragments(s.bonds, s.particles, s.domain);
    add_particles(renderer, s, cut, colours, colours_of(fragments, s.particles));
    add_fragment_legend(renderer, fragments);
  } else {
    add_particles(renderer, s, cut, colours);
    add_speed_scale(renderer, colours, speeds);
  }

  // What the view must hold, across the axis: the extent of everything that is drawn.
  double half_width = 0, half_height = 0;
  double left = 1e300, right = -1e300, low = 1e300, high = -1e300;
  const auto hold = [&](const Vec3& point, double across, double along) {
    const Vec3 d = point - shown.centre;
    left = std::min(left, d.dot(view.right) - across), right = std::max(right, d.dot(view.right) + across);
    low = std::min(low, d.dot(view.up) - along), high = std::max(high, d.dot(view.up) + along);
  };
  for (std::size_t k = 0; k < static_cast<std::size_t>(s.particles.owned); ++k) {
    const Quad& q = s.particles.position[k];
    if (std::isfinite(q.x + q.y + q.z)) hold(vec(q), reach(s, k, view.right), reach(s, k, view.up));
  }
  for (const Wall& wall : s.walls)
    if (!std::holds_alternative<Plane>(wall.surface))
      for (const Vec3& point : facets_of(wall, shown).points) hold(point, 0, 0);
  if (right < left) left = low = -1, right = high = 1;
  half_width = 0.5 * (right - left), half_height = 0.5 * (high - low);
  const Vec3 middle = shown.centre + 0.5 * (left + right) * view.right + 0.5 * (low + high) * view.up;

  for (const ShellMark& mark : picture.marks) {
    const double r = std::max(half_width, half_height);
    const Vec3 from = middle + 0.9 * r * mark.direction + 2 * shown.radius * view.towards;
    const Vec3 to = middle + 1.08 * r * mark.direction + 2 * shown.radius * view.towards;
    const Vec3 side = 0.004 * r * view.towards.cross(mark.direction);
    auto line = surface_of({{from - side, from + side, to + side, to - side}, {{0, 1, 2}, {0, 2, 3}}}, {0.80, 0.10, 0.10}, 1.0);
    line->GetProperty()->LightingOff();
    renderer->AddActor(line);
    const Vec3 place = middle + 1.11 * r * mark.direction;
    const auto label = add_text(renderer, mark.label, 0, 0, 20);
    const double sideways = mark.direction.dot(view.right);
    if (sideways > 0.2) label->GetTextProperty()->SetJustificationToLeft();
    if (sideways < -0.2) label->GetTextProperty()->SetJustificationToRight();
    if (std::abs(sideways) <= 0.2 && mark.direction.dot(view.up) < 0) label->GetTextProperty()->SetVerticalJustificationToTop();
    label->GetPositionCoordinate()->SetCoordinateSystemToWorld();
    label->GetPositionCoordinate()->SetValue(place.x(), place.y(), place.z());
  }

  // The drawing stands left of the scale, below the title and above the caption.
  constexpr double free_left = 40, free_right = 960, free_low = 90, free_high = 830;
  const double margin = picture.marks.empty() ? 1.09 : 1.14;
  const double metres_per_pixel = margin * std::max(2 * half_width / (free_right - free_left), 2 * half_height / (free_high - free_low));
  const Vec3 focus = middle + (0.5 * width - 0.5 * (free_left + free_right)) * metres_per_pixel * view.right +
                     (0.5 * height - 0.5 * (free_low + free_high)) * metres_per_pixel * view.up;
  vtkCamera* camera = renderer->GetActiveCamera();
  const Vec3 eye = focus + 10 * std::max(shown.radius, 1e-9) * view.towards;
  camera->SetFocalPoint(focus.data());
  camera->SetPosition(eye.data());
  camera->SetViewUp(view.up.data());
  camera->ParallelProjectionOn();
  camera->SetParallelScale(0.5 * height * metres_per_pixel);
  renderer->ResetCameraClippingRange();

  add_line_of_text(renderer, picture.title, 868, 26, true);
  add_line_of_text(renderer, picture.caption, 36, 20, false);

  render(renderer, path);
}

namespace {

void fill(vtkDoubleArray* column, const char* name, const std::vector<double>& values) {
  column->SetName(name);
  for (const double value : values) column->InsertNextValue(value);
}

void dress(vtkAxis* axis, const AxisScale& scale) {
  axis->SetTitle("");
  set_type(axis->GetLabelProperties(), 20);
  axis->GetPen()->SetWidth(1.5f * finer);
  axis->GetPen()->SetColorF(ink[0], ink[1], ink[2]);
  axis->GetGridPen()->SetColorF(0.90, 0.90, 0.91);
  axis->GetGridPen()->SetWidth(1.0f * finer);
  axis->SetTickLength(6.0f * finer);
  axis->SetLabelOffset(9.0f * finer);
  axis->SetBehavior(vtkAxis::FIXED);
  axis->SetRange(scale.from, scale.to);
  vtkNew<vtkDoubleArray> places;
  vtkNew<vtkStringArray> labels;
  for (const double tick : scale.ticks) places->InsertNextValue(tick);
  for (const std::string& label : scale.labels) labels->InsertNextValue(label);
  axis->SetCustomTickPositions(places, labels);
}

vtkPlot* add_line(vtkChartXY* chart, const std::string& name, const std::vector<double>& x, const std::vector<double>& y, const Colour& colour,
                  float thickness) {
  vtkNew<vtkTable> table;
  vtkNew<vtkDoubleArray> xs, ys;
  fill(xs, "x", x), fill(ys, name.c_str(), y);
  if (x.size() == 1) xs->InsertNextValue(x[0]), ys->InsertNextValue(y[0]);  // VTK draws no line of one point, but says so
  table->AddColumn(xs), table->AddColumn(ys);
  vtkPlot* line = chart->AddPlot(vtkChart::LINE);
  line->SetInputData(table, 0, 1);
  line->SetLabel(name);
  line->GetPen()->SetColorF(colour[0], colour[1], colour[2]);
  line->SetWidth(finer * thickness);
  return line;
}

void add_band(vtkChartXY* chart, const std::vector<double>& x, const std::vector<double>& low, const std::vector<double>& high, const Colour& colour,
              double opacity = 0.30) {
  vtkNew<vtkTable> table;
  vtkNew<vtkDoubleArray> xs, band;
  fill(xs, "x", x);
  band->SetName("band");
  band->SetNumberOfComponents(2);
  for (std::size_t k = 0; k < low.size(); ++k) band->InsertNextTuple2(low[k], high[k]);
  table->AddColumn(xs), table->AddColumn(band);
  auto* bag = vtkPlotFunctionalBag::SafeDownCast(chart->AddPlot(vtkChart::FUNCTIONALBAG));
  bag->SetInputData(table, 0, 1);
  bag->GetPen()->SetColorF(colour[0], colour[1], colour[2]);  // VTK fills the bag with the colour of its pen
  bag->GetPen()->SetLineType(vtkPen::NO_PEN);
  bag->GetBrush()->SetColorF(colour[0], colour[1], colour[2], opacity);
  bag->SetLegendVisibility(false);
}

// The points of a curve that the axes can show, in the axes' own measure. The chart is drawn on linear axes throughout.
struct Shown {
  std::vector<double> x, y, low, high;
};
Shown shown(const Curve& curve, const Panel& panel, Extent& x_range, Extent& y_range) {
  Shown out;
  const bool interval = curve.lower.size() == curve.y.size() && curve.upper.size() == curve.y.size();
  const auto measure = [](bool log, double value) { return log ? std::log10(value) : value; };
  for (std::size_t k = 0; k < std::min(curve.x.size(), curve.y.size()); ++k) {
    const double x = curve.x[k], y = curve.y[k];
    if (!std::isfinite(x) || !std::isfinite(y) || (panel.log_x && x <= 0) || (panel.log_y && y <= 0)) continue;
    out.x.push_back(measure(panel.log_x, x)), out.y.push_back(measure(panel.log_y, y));
    x_range.hold(out.x.back()), y_range.hold(out.y.back());
    if (!interval) continue;
    // A count of one may come from a mean of nearly nothing: such a bar ends a decade below its point.
    const double low = panel.log_y ? std::max(curve.lower[k], 0.1 * y) : curve.lower[k], high = curve.upper[k];
    out.low.push_back(measure(panel.log_y, low)), out.high.push_back(measure(panel.log_y, high));
    y_range.hold(out.low.back()), y_range.hold(out.high.back());
  }
  return out;
}

constexpr int legend_line = 26;  // [pixel]

// On which side the legend hides less, and the y range with the room that it needs there.
bool legend_goes_left(const std::vector<Shown>& curves, const Extent& x_range, Extent& y_range, double legend_share) {
  Extent left, right;
  for (const Shown& c : curves) {
    for (std::size_t k = 0; k < c.x.size(); ++k) {
      const double at = (c.x[k] - x_range.low) / (x_range.high - x_range.low), y = c.high.empty() ? c.y[k] : c.high[k];
      if (at < 0.42) left.hold(y);
      if (at > 0.58) right.hold(y);
    }
  }
  const double highest = std::min(left.high, right.high), share = std::min(legend_share, 0.6);
  y_range.high = std::max(y_range.high, y_range.low + (highest - y_range.low) / (1 - share));
  return left.high < right.high;
}

// `tall`: height of the panel's frame [pixel].
const Colour& colour_of(const Panel& panel, std::size_t curve) {
  const int like = panel.curves[curve].like;
  return palette[(like < 0 ? curve : static_cast<std::size_t>(like)) % palette.size()];
}

void fill_panel(vtkChartXY* chart, const Panel& panel, double tall) {
  Extent x_range, y_range;
  std::vector<Shown> curves;
  for (const Curve& curve : panel.curves) curves.push_back(shown(curve, panel, x_range, y_range));
  if (panel.log_y) {
    y_range.high += 0.1;  // of a decade
  } else if (y_range.low < y_range.high) {
    if (y_range.low > 0 && y_range.low < 0.4 * y_range.high) y_range.low = 0;
    const double room = 0.03 * (y_range.high - y_range.low);
    if (y_range.low != 0) y_range.low -= room;
    y_range.high += room;
  }
  if (panel.marked && !panel.log_x && y_range.low < y_range.high) {
    // From far below to far above: the legend may still ask for room.
    const double beyond = 10 * (y_range.high - y_range.low), low = y_range.low - beyond, high = y_range.high + beyond;
    add_band(chart, {(*panel.marked)[0], (*panel.marked)[1]}, {low, low}, {high, high}, palette[5], 0.15);
  }
  for (std::size_t k = 0; k < curves.size(); ++k) {
    const Shown& c = curves[k];
    const Colour& colour = colour_of(panel, k);
    if (c.x.empty()) continue;
    if (!c.low.empty() && !panel.curves[k].marks) add_band(chart, c.x, c.low, c.high, colour);
    if (!c.low.empty() && panel.curves[k].marks) {
      for (std::size_t i = 0; i < c.x.size(); ++i) {
        vtkPlot* bar = add_line(chart, "", {c.x[i], c.x[i]}, {c.low[i], c.high[i]}, colour, 1.2f);
        bar->SetLegendVisibility(false);
      }
    }
  }
  for (std::size_t k = 0; k < curves.size(); ++k) {
    if (curves[k].x.empty()) continue;
    vtkPlot* line = add_line(chart, panel.curves[k].name, curves[k].x, curves[k].y, colour_of(panel, k), panel.curves[k].marks ? 1.5f : 2.2f);
    line->SetLegendVisibility(!panel.curves[k].name.empty());
    if (panel.curves[k].marks && !panel.curves[k].joined) line->GetPen()->SetLineType(vtkPen::NO_PEN);
    if (auto* points = vtkPlotPoints::SafeDownCast(line); points && panel.curves[k].marks) {
      points->SetMarkerStyle(vtkPlotPoints::CIRCLE);
      points->SetMarkerSize((panel.curves[k].small ? 4.0f : 8.0f) * finer);
    }
  }
  const auto named = std::count_if(panel.curves.begin(), panel.curves.end(), [](const Curve& curve) { return !curve.name.empty(); });
  const bool legend = named > 1 && x_range.low < x_range.high;
  const double share = (legend_line * static_cast<double>(named) + 16) / tall;
  const bool left = legend && legend_goes_left(curves, x_range, y_range, share);
  dress(chart->GetAxis(vtkAxis::BOTTOM), panel.log_x ? log_scale(x_range, has_font()) : linear_scale(x_range));
  dress(chart->GetAxis(vtkAxis::LEFT), panel.log_y ? log_scale(y_range, has_font()) : linear_scale(y_range));
  if (!legend) return;
  chart->SetShowLegend(true);
  set_type(chart->GetLegend()->GetLabelProperties(), 20);
  chart->GetLegend()->SetSymbolWidth(30 * finer);
  chart->GetLegend()->SetPadding(6 * finer);
  chart->GetLegend()->SetHorizontalAlignment(left ? vtkChartLegend::LEFT : vtkChartLegend::RIGHT);
  chart->GetLegend()->SetVerticalAlignment(vtkChartLegend::TOP);
  chart->GetLegend()->GetPen()->SetLineType(vtkPen::NO_PEN);
  chart->GetLegend()->GetBrush()->SetColorF(1, 1, 1, left ? 0.0 : 0.85);  // on the left it would hide the axis
}

}  // namespace

void draw_chart(const Chart& chart, const std::string& path) {
  vtkNew<vtkRenderer> renderer;
  renderer->SetBackground(1, 1, 1);
  vtkNew<vtkContextActor> canvas;
  renderer->AddActor(canvas);
  canvas->GetScene()->SetRenderer(renderer);
  // The frames of all panels stand exactly below each other.
  constexpr float left = 130, right = 1160, top = 830, bottom = 85, space = 45, label_space = 90;
  const auto panels = static_cast<float>(std::max<std::size_t>(chart.panels.size(), 1));
  const bool one_label = std::all_of(chart.panels.begin(), chart.panels.end(), [&](const Panel& p) { return p.x_label == chart.panels.front().x_label; });
  const float gap = one_label ? space : label_space, each = (top - bottom - gap * (panels - 1)) / panels;
  for (std::size_t k = 0; k < chart.panels.size(); ++k) {
    const float from = top - each * static_cast<float>(k + 1) - gap * static_cast<float>(k);
    vtkNew<vtkChartXY> panel;
    panel->SetAutoSize(false);
    panel->SetLayoutStrategy(vtkChart::AXES_TO_RECT);
    panel->SetSize(vtkRectf(finer * left, finer * from, finer * (right - left), finer * each));
    fill_panel(panel, chart.panels[k], each);
    canvas->GetScene()->AddItem(panel);
    add_text(renderer, chart.panels[k].y_label, 38, from + 0.5 * each, 23)->GetTextProperty()->SetOrientation(90);
    if (k + 1 == chart.panels.size() || !one_label) add_text(renderer, chart.panels[k].x_label, 0.5 * (left + right), from - 55, 23);
  }
  add_line_of_text(renderer, chart.title, 868, 26, true);
  render(renderer, path);
}

}  // namespace quern
