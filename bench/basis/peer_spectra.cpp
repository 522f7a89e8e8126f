// Spectra: SymEigsShiftSolver on the symmetrized operator, factored by Eigen's SimplicialLLT.
// Reads the raw arrays that run.py writes beside the exported operator: n, nnz, indptr, indices,
// data, mass. Prints one JSON line as measure.py does.
#include <Eigen/Sparse>
#include <Spectra/SymEigsShiftSolver.h>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <vector>

using Sparse = Eigen::SparseMatrix<double>;
using Vector = Eigen::VectorXd;

struct ShiftSolve {
    using Scalar = double;
    explicit ShiftSolve(const Sparse &a) : matrix(a) {}
    Eigen::Index rows() const { return matrix.rows(); }
    Eigen::Index cols() const { return matrix.cols(); }
    void set_shift(const double &sigma) {
        Sparse shifted = matrix;
        for (Eigen::Index i = 0; i < shifted.rows(); ++i) shifted.coeffRef(i, i) -= sigma;
        factor.compute(shifted);
    }
    void perform_op(const double *in, double *out) const {
        Eigen::Map<const Vector> x(in, rows());
        Eigen::Map<Vector>(out, rows()) = factor.solve(x);
    }
    const Sparse &matrix;
    Eigen::SimplicialLLT<Sparse> factor;
};

template <class T> std::vector<T> read(FILE *file, size_t count) {
    std::vector<T> values(count);
    if (fread(values.data(), sizeof(T), count, file) != count) { fprintf(stderr, "short file\n"); exit(1); }
    return values;
}

int main(int, char **argv) {
    FILE *file = fopen(argv[1], "rb");
    if (!file) { fprintf(stderr, "cannot open %s\n", argv[1]); return 1; }
    const auto head = read<int64_t>(file, 2);
    const int64_t n = head[0], nnz = head[1], k = atoll(argv[2]);
    const auto starts = read<int64_t>(file, n + 1), rows = read<int64_t>(file, nnz);
    const auto data = read<double>(file, nnz), mass = read<double>(file, n);
    fclose(file);
    const auto start = std::chrono::steady_clock::now();
    std::vector<Eigen::Triplet<double>> entries;
    for (int64_t j = 0; j < n; ++j)
        for (int64_t at = starts[j]; at < starts[j + 1]; ++at)
            entries.emplace_back(rows[at], j, data[at] / std::sqrt(mass[j] * mass[rows[at]]));
    Sparse a(n, n);
    a.setFromTriplets(entries.begin(), entries.end());
    ShiftSolve op(a);
    Spectra::SymEigsShiftSolver<ShiftSolve> solver(op, k, std::min(n, 2 * k), -0.01);
    solver.init();
    solver.compute(Spectra::SortRule::LargestMagn, 1000, 1e-10, Spectra::SortRule::SmallestAlge);
    const Vector values = solver.eigenvalues();
    const Eigen::MatrixXd x = solver.eigenvectors();
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    double residual = 0;
    const Vector root = Eigen::Map<const Vector>(mass.data(), n).cwiseSqrt();
    for (Eigen::Index i = 0; i < values.size(); ++i) {
        if (values[i] < 1e-7) continue;
        // S h − λ a h and S h with h = x / √a.
        const Vector image = (a * x.col(i)).cwiseProduct(root), h = x.col(i).cwiseProduct(root) * values[i];
        residual = std::max(residual, (image - h).norm() / image.norm());
    }
    double orthogonality = 0;
    for (Eigen::Index i = 0; i < x.cols(); i += 256) {
        const Eigen::Index width = std::min<Eigen::Index>(256, x.cols() - i);
        Eigen::MatrixXd gram = x.middleCols(i, width).transpose() * x;
        for (Eigen::Index j = 0; j < width; ++j) gram(j, i + j) -= 1;
        orthogonality = std::max(orthogonality, gram.cwiseAbs().maxCoeff());
    }
    printf("{\"seconds\": %.6f, \"residual\": %.3e, \"orthogonality\": %.3e, \"count\": %lld, \"last\": %.12g}\n",
           seconds, residual, orthogonality, (long long)values.size(), values.size() ? values[values.size() - 1] : 0.0);
}
