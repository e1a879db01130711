#include "probes/linear_solver.h"

#include "core/parallel.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace lightgrid {
namespace {

using Vector = std::vector<glm::dvec3>;

/// Vectors kept until a restart. The spectrum of light transport is a few large eigenvalues and a heap near zero, so
/// that few are needed.
constexpr int most_vectors = 40;
/// Vectors are worked on in blocks of this many values, so that sums do not depend on threads.
constexpr std::size_t block = 4096;

template <typename Body>  // body(begin, end, block index)
void for_each_block(std::size_t size, Body body) {
    for_each_index((size + block - 1) / block,
                   [&](std::size_t i) { body(i * block, std::min(size, (i + 1) * block), i); });
}

glm::dvec3 color_dot(std::span<const glm::dvec3> a, std::span<const glm::dvec3> b) {
    std::vector<glm::dvec3> sums((a.size() + block - 1) / block, glm::dvec3(0));
    for_each_block(a.size(), [&](std::size_t begin, std::size_t end, std::size_t i) {
        for (std::size_t k = begin; k < end; ++k) sums[i] += a[k] * b[k];
    });
    glm::dvec3 sum(0);
    for (const glm::dvec3& s : sums) sum += s;
    return sum;
}

glm::dvec3 norm(std::span<const glm::dvec3> a) {
    return glm::sqrt(color_dot(a, a));
}

/// y += factor x
void add(glm::dvec3 factor, std::span<const glm::dvec3> x, std::span<glm::dvec3> y) {
    for_each_block(x.size(), [&](std::size_t begin, std::size_t end, std::size_t) {
        for (std::size_t k = begin; k < end; ++k) y[k] += factor * x[k];
    });
}

/// a / b by colour; 0 where a colour has nothing left to solve.
glm::dvec3 divide(glm::dvec3 a, glm::dvec3 b) {
    return {b.x != 0 ? a.x / b.x : 0, b.y != 0 ? a.y / b.y : 0, b.z != 0 ? a.z / b.z : 0};
}

double largest(glm::dvec3 v) {
    return std::max({v.x, v.y, v.z});
}

/// Grows an orthonormal basis of the Krylov space of a residual and the triangular factor of the small least-squares
/// problem in it, by Givens rotations; everything by colour.
class KrylovSpace {
  public:
    KrylovSpace(const ColorOperator& a, Vector residual) : a_(a) {
        const glm::dvec3 length = norm(residual);
        const glm::dvec3 inverse = divide(glm::dvec3(1), length);
        for (glm::dvec3& value : residual) value *= inverse;
        basis_.push_back(std::move(residual));
        right_.push_back(length);
    }

    [[nodiscard]] int size() const { return static_cast<int>(columns_.size()); }
    /// Of the least-squares problem: the length of the residual if one stopped here.
    [[nodiscard]] glm::dvec3 residual() const { return glm::abs(right_.back()); }

    void grow() {
        Vector next(basis_[0].size());
        a_(basis_.back(), next);
        std::vector<glm::dvec3> column;
        for (const Vector& v : basis_) {
            column.push_back(color_dot(v, next));
            add(-column.back(), v, next);
        }
        glm::dvec3 length = norm(next);
        const glm::dvec3 inverse = divide(glm::dvec3(1), length);
        for (glm::dvec3& value : next) value *= inverse;
        basis_.push_back(std::move(next));

        for (std::size_t k = 0; k < rotations_.size(); ++k) {
            const auto [cosine, sine] = rotations_[k];
            const glm::dvec3 upper = column[k];
            column[k] = cosine * upper + sine * column[k + 1];
            column[k + 1] = cosine * column[k + 1] - sine * upper;
        }
        const glm::dvec3 hypotenuse = glm::sqrt(column.back() * column.back() + length * length);
        const glm::dvec3 cosine = divide(column.back(), hypotenuse);
        const glm::dvec3 sine = divide(length, hypotenuse);
        column.back() = hypotenuse;
        rotations_.push_back({cosine, sine});
        columns_.push_back(std::move(column));
        right_.push_back(-sine * right_.back());
        right_[right_.size() - 2] *= cosine;
    }

    void add_solution(Vector& x) const {
        std::vector<glm::dvec3> y(columns_.size());
        for (std::size_t i = columns_.size(); i-- > 0;) {
            glm::dvec3 sum = right_[i];
            for (std::size_t k = i + 1; k < columns_.size(); ++k) sum -= columns_[k][i] * y[k];
            y[i] = divide(sum, columns_[i][i]);
            add(y[i], basis_[i], x);
        }
    }

  private:
    struct Rotation {
        glm::dvec3 cosine, sine;
    };

    const ColorOperator& a_;
    std::vector<Vector> basis_;
    std::vector<std::vector<glm::dvec3>> columns_;  // of the triangular factor
    std::vector<Rotation> rotations_;
    std::vector<glm::dvec3> right_;  // the residual's length, rotated as the columns were
};

}  // namespace

Solution solve_linear(const ColorOperator& a, std::span<const glm::dvec3> b, double tolerance, int most_sweeps) {
    Solution solution;
    solution.x.assign(b.size(), glm::dvec3(0));
    const glm::dvec3 scale = norm(b);
    Vector residual(b.begin(), b.end());
    for (;;) {
        solution.residual = largest(divide(norm(residual), scale));
        if (solution.residual <= tolerance || solution.sweeps >= most_sweeps) return solution;
        KrylovSpace space(a, std::move(residual));
        while (space.size() < most_vectors && solution.sweeps < most_sweeps) {
            space.grow();
            ++solution.sweeps;
            if (largest(divide(space.residual(), scale)) <= 0.5 * tolerance) break;  // room for rounding
        }
        space.add_solution(solution.x);
        residual.assign(b.size(), glm::dvec3(0));
        a(solution.x, residual);
        ++solution.sweeps;
        for (std::size_t i = 0; i < b.size(); ++i) residual[i] = b[i] - residual[i];
    }
}

}  // namespace lightgrid
