// src/base — vectors and rotations, SIMD packs, units, errors, random streams, threads: what everything stands on. No physics.
//
// Vectors for everything outside the inner loops, and the way between them and the rows of the particle arrays.
#pragma once
#include <Eigen/Core>
#include <Eigen/Geometry>
#include "src/base/triple.hpp"

namespace quern {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;
using Rotation = Eigen::Quaterniond;

QUERN_INLINE Vec3 vec(const Quad& q) { return {q.x, q.y, q.z}; }
QUERN_INLINE Vec3 vec(const Triple<double>& t) { return {t.x, t.y, t.z}; }
QUERN_INLINE Triple<double> triple(const Vec3& v) { return {v.x(), v.y(), v.z()}; }
QUERN_INLINE Quad row(const Vec3& v, double companion = 0) { return {v.x(), v.y(), v.z(), companion}; }
QUERN_INLINE Rotation rotation_of(const Quad& q) { return {q.w, q.x, q.y, q.z}; }
QUERN_INLINE void set(Quad& q, const Vec3& v) { q.x = v.x(), q.y = v.y(), q.z = v.z(); }
QUERN_INLINE void add(Quad& q, const Vec3& v) { q.x += v.x(), q.y += v.y(), q.z += v.z(); }

}  // namespace quern
