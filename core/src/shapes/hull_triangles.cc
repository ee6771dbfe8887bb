#include "shapes/hull_triangles.h"

#include <libqhull_r/qhull_ra.h>

#include <cstdio>
#include <memory>
#include <utility>

namespace genphys {
namespace {

// One run of the library: it has memory of its own, and reports by files.
class Qhull {
 public:
  explicit Qhull(const std::vector<Vector3>& points)
      : coordinates_(points.data()->data(), points.data()->data() + 3 * points.size()),
        nowhere_(std::fopen("/dev/null", "w")) {
    qh_zero(&qh_, nowhere_.get());
    // Joggled input: every facet is a triangle and every edge has two, whatever the rounding. The points themselves
    // stay where they are, since only their numbers are taken from here.
    char options[] = "qhull QJ Pp";
    failed_ = qh_new_qhull(&qh_, 3, static_cast<int>(points.size()), coordinates_.data(), False, options, nullptr,
                           nowhere_.get()) != 0;
  }
  Qhull(const Qhull&) = delete;
  Qhull& operator=(const Qhull&) = delete;
  ~Qhull() {
    int left = 0, total = 0;
    qh_freeqhull(&qh_, qh_ALL == 0);
    qh_memfreeshort(&qh_, &left, &total);
  }

  std::vector<HullTriangle> Triangles() {
    std::vector<HullTriangle> triangles;
    if (failed_) return triangles;
    for (facetT* facet = qh_.facet_list; facet != nullptr && facet->next != nullptr; facet = facet->next) {
      HullTriangle triangle{};
      for (size_t i = 0; i < 3; ++i) {
        const auto* vertex = static_cast<const vertexT*>(facet->vertices->e[i].p);
        triangle[i] = static_cast<uint32_t>(qh_pointid(&qh_, vertex->point));
      }
      if (!IsOutward(triangle, facet->normal)) std::swap(triangle[1], triangle[2]);
      triangles.push_back(triangle);
    }
    return triangles;
  }

 private:
  // By the joggled points, of which no three lie on a line.
  bool IsOutward(const HullTriangle& t, const double* normal) const {
    const auto point = [&](size_t i) { return Eigen::Map<const Vector3>(coordinates_.data() + 3 * size_t{t[i]}); };
    const Vector3 area = (point(1) - point(0)).cross(point(2) - point(0));
    return area.dot(Eigen::Map<const Vector3>(normal)) > 0;
  }

  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };

  std::vector<double> coordinates_;  // the library moves them
  std::unique_ptr<std::FILE, Close> nowhere_;
  qhT qh_{};
  bool failed_ = false;
};

}  // namespace

std::vector<HullTriangle> HullTriangles(const std::vector<Vector3>& points) { return Qhull(points).Triangles(); }

}  // namespace genphys
