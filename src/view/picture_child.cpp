// overtet-picture: draws one scene with VTK, in a process of its own, so that nobody else links VTK or waits
// for it to load, and so that what it does wrong stays here. Not a command for people: see picture_wire.h.
//
//   overtet-picture PARENT_PID
//
// Debian's VTK makes windows of X only. Here it draws into a context that EGL makes without any window, by
// Mesa's software renderer: no display, no graphics card, the same bytes on each machine with this Mesa.
#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <dlfcn.h>
#include <signal.h>
#include <sys/prctl.h>
#include <unistd.h>
#include <vtkActor.h>
#include <vtkCamera.h>
#include <vtkCellArray.h>
#include <vtkFloatArray.h>
#include <vtkGenericOpenGLRenderWindow.h>
#include <vtkIdTypeArray.h>
#include <vtkMapper.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <new>
#include <vector>

#include "src/view/picture_wire.h"

// GLEW finds the functions of OpenGL for VTK, and then misses a display of X (its error 4), which VTK takes
// for a failure. VTK calls this instead, as the program's own functions come first.
extern "C" __attribute__((visibility("default"))) unsigned glewInit() {
  const auto original = reinterpret_cast<unsigned (*)()>(dlsym(RTLD_NEXT, "glewInit"));
  const unsigned error = original ? original() : 1;
  return error == 4 ? 0 : error;
}

namespace {

using overtet::view::picture_wire::Request;

[[noreturn]] void give_up(const char* why) {
  std::fputs(why, stderr);
  std::fflush(stderr);
  _exit(1);
}

void read_all(void* data, std::size_t bytes) {
  char* at = static_cast<char*>(data);
  while (bytes > 0) {
    const ssize_t got = read(0, at, std::min<std::size_t>(bytes, 1 << 30));
    if (got <= 0) give_up("it got no whole scene");
    at += got;
    bytes -= static_cast<std::size_t>(got);
  }
}

void write_all(const void* data, std::size_t bytes) {
  const char* at = static_cast<const char*>(data);
  while (bytes > 0) {
    const ssize_t put = write(1, at, std::min<std::size_t>(bytes, 1 << 30));
    if (put <= 0) give_up("there is no memory for the picture");
    at += put;
    bytes -= static_cast<std::size_t>(put);
  }
}

template <class T>
std::vector<T> numbers(std::int64_t count) {
  std::vector<T> all(static_cast<std::size_t>(count));
  read_all(all.data(), all.size() * sizeof(T));
  return all;
}

// Mesa's software renderer, whatever card there is, and as it is on the smallest processor: 128 bits at a
// time.
void make_context() {
  setenv("LIBGL_ALWAYS_SOFTWARE", "1", 1);
  setenv("GALLIUM_DRIVER", "llvmpipe", 1);
  setenv("LP_NATIVE_VECTOR_WIDTH", "128", 1);
  setenv("MESA_SHADER_CACHE_DISABLE", "true", 1);
  const EGLDisplay display = eglGetPlatformDisplay(EGL_PLATFORM_SURFACELESS_MESA,
                                                   reinterpret_cast<void*>(EGL_DEFAULT_DISPLAY), nullptr);
  EGLint major = 0, minor = 0, found = 0;
  if (display == EGL_NO_DISPLAY || !eglInitialize(display, &major, &minor))
    give_up("EGL has no display without a window; install libegl1 and libgl1-mesa-dri");
  const EGLint wanted[] = {EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_NONE};
  const EGLint version[] = {EGL_CONTEXT_MAJOR_VERSION,
                            3,
                            EGL_CONTEXT_MINOR_VERSION,
                            2,
                            EGL_CONTEXT_OPENGL_PROFILE_MASK,
                            EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                            EGL_NONE};
  EGLConfig config = nullptr;
  if (!eglBindAPI(EGL_OPENGL_API) || !eglChooseConfig(display, wanted, &config, 1, &found) || found == 0)
    give_up("EGL has no OpenGL; install libgl1-mesa-dri");
  const EGLContext context = eglCreateContext(display, config, EGL_NO_CONTEXT, version);
  if (context == EGL_NO_CONTEXT || !eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context))
    give_up("EGL makes no context for OpenGL 3.2; install libgl1-mesa-dri");
}

// Cells of so many points each, none of which two share.
vtkNew<vtkPolyData> cells_of(const std::vector<float>& coordinates, int corners) {
  const auto count = static_cast<vtkIdType>(coordinates.size() / 3);
  vtkNew<vtkFloatArray> places;
  places->SetNumberOfComponents(3);
  places->SetArray(const_cast<float*>(coordinates.data()), 3 * count, 1);
  vtkNew<vtkPoints> points;
  points->SetData(places);
  vtkNew<vtkIdTypeArray> offsets, ids;
  offsets->SetNumberOfValues(count / corners + 1);
  for (vtkIdType i = 0; i <= count / corners; ++i) offsets->SetValue(i, corners * i);
  ids->SetNumberOfValues(count);
  for (vtkIdType i = 0; i < count; ++i) ids->SetValue(i, i);
  vtkNew<vtkCellArray> cells;
  cells->SetData(offsets, ids);
  vtkNew<vtkPolyData> data;
  data->SetPoints(points);
  if (corners == 3) data->SetPolys(cells);
  if (corners == 2) data->SetLines(cells);
  if (corners == 1) data->SetVerts(cells);
  return data;
}

struct Look {
  double red = 0, green = 0, blue = 0, width = 1, opacity = 1;
};

// Its size is in pixels of the picture.
void show(vtkRenderer* renderer, vtkPolyData* data, const Look& look, double samples) {
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(data);
  mapper->SetColorModeToDirectScalars();
  vtkNew<vtkActor> actor;
  actor->SetMapper(mapper);
  vtkProperty* property = actor->GetProperty();
  property->LightingOff();  // it is part of the colours
  property->SetColor(look.red, look.green, look.blue);
  property->SetOpacity(look.opacity);
  property->SetLineWidth(static_cast<float>(look.width * samples));
  property->SetPointSize(static_cast<float>(look.width * samples));
  renderer->AddActor(actor);
}

// Each pixel: the mean of a square of samples.
std::vector<unsigned char> picture_of(const unsigned char* drawn, const Request& r) {
  const std::int64_t n = r.samples, wide = r.width * n;
  std::vector<unsigned char> pixels(3 * static_cast<std::size_t>(r.width) *
                                    static_cast<std::size_t>(r.height));
  std::size_t to = 0;
  for (std::int64_t y = r.height - 1; y >= 0; --y)  // OpenGL counts from below
    for (std::int64_t x = 0; x < r.width; ++x)
      for (int k = 0; k < 3; ++k) {
        std::int64_t sum = n * n / 2;
        for (std::int64_t j = 0; j < n; ++j)
          for (std::int64_t i = 0; i < n; ++i) sum += drawn[3 * ((n * y + j) * wide + n * x + i) + k];
        pixels[to++] = static_cast<unsigned char>(sum / (n * n));
      }
  return pixels;
}

void draw(const Request& r) {
  const std::vector<float> corners = numbers<float>(9 * r.triangles);
  const std::vector<unsigned char> colours = numbers<unsigned char>(3 * r.triangles);
  const std::vector<float> wires = numbers<float>(6 * r.wires), lines = numbers<float>(6 * r.lines),
                           marks = numbers<float>(3 * r.marks);
  make_context();
  vtkMapper::SetResolveCoincidentTopologyToPolygonOffset();  // lines on faces stay visible

  vtkNew<vtkRenderer> solid, shining;
  solid->SetBackground(1, 1, 1);
  vtkNew<vtkGenericOpenGLRenderWindow> window;
  window->SetReadyForRendering(true);
  window->SetIsCurrent(true);
  window->SetSupportsOpenGL(true);
  window->SetOffScreenRendering(1);
  window->SetMultiSamples(0);
  window->SetSize(r.width * r.samples, r.height * r.samples);
  window->SetNumberOfLayers(2);
  window->AddRenderer(solid);
  window->AddRenderer(shining);
  shining->SetLayer(1);
  vtkCamera* camera = solid->GetActiveCamera();
  camera->SetPosition(r.eye);
  camera->SetFocalPoint(r.target);
  camera->SetViewUp(r.up);
  camera->SetViewAngle(r.height_degrees);
  camera->SetClippingRange(r.near, r.far);
  shining->SetActiveCamera(camera);

  const auto faces = cells_of(corners, 3);
  vtkNew<vtkUnsignedCharArray> scalars;  // of corners: tables of cells are limited by the renderer
  scalars->SetNumberOfComponents(3);
  scalars->SetNumberOfTuples(3 * r.triangles);
  for (std::int64_t i = 0; i < 3 * r.triangles; ++i)
    for (int k = 0; k < 3; ++k)
      scalars->SetTypedComponent(i, k, colours[static_cast<std::size_t>(3 * (i / 3) + k)]);
  faces->GetPointData()->SetScalars(scalars);
  if (r.triangles > 0) show(solid, faces, {}, r.samples);
  if (r.wires > 0) show(solid, cells_of(wires, 2), {.25, .25, .25, .6}, r.samples);
  const auto* m = r.mark_colour;
  for (const auto& [renderer, opacity] : {std::pair(solid.Get(), 1.), std::pair(shining.Get(), .35)}) {
    const auto look = [&](double width) {
      return Look{m[0] / 255., m[1] / 255., m[2] / 255., width, opacity};
    };
    if (r.lines > 0) show(renderer, cells_of(lines, 2), look(2), r.samples);
    if (r.marks > 0) show(renderer, cells_of(marks, 1), look(7), r.samples);
  }
  window->Render();
  vtkNew<vtkUnsignedCharArray> drawn;
  const int right = r.width * r.samples - 1, top = r.height * r.samples - 1;
  static_cast<vtkRenderWindow&>(*window.Get()).GetPixelData(0, 0, right, top, 0, drawn);
  if (drawn->GetNumberOfValues() != 3ll * (right + 1) * (top + 1)) give_up("VTK has drawn nothing");
  const std::vector<unsigned char> pixels = picture_of(drawn->GetPointer(0), r);
  write_all(pixels.data(), pixels.size());
}

}  // namespace

int main(int argc, char** argv) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (argc != 2 || getppid() != std::atoi(argv[1])) give_up("overtet-picture draws for overtet view");
  try {
    Request r;
    read_all(&r, sizeof r);
    if (r.magic != Request().magic) give_up("overtet-picture is of another version; install both again");
    draw(r);
  } catch (const std::bad_alloc&) {
    give_up("there is not enough memory to draw it");
  }
  _exit(0);  // leaving it to VTK to clean up takes longer than drawing
}
