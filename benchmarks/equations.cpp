// Pinocchio's mass matrix and forces, and derivatives, called as a C++ program would call them.
#include <chrono>
#include <fstream>
#include <string>
#include <vector>

#include <pinocchio/multibody.hpp>
#include <pinocchio/algorithm/crba.hpp>
#include <pinocchio/algorithm/rnea.hpp>
#include <pinocchio/algorithm/aba-derivatives.hpp>
#include <pinocchio/algorithm/aba.hpp>
#include <pinocchio/algorithm/rnea-derivatives.hpp>
#include <pinocchio/algorithm/joint-configuration.hpp>

namespace
{
pinocchio::Model model;
pinocchio::Data *data;
std::vector<Eigen::VectorXd> q, v, a;
double sink;

template <typename Joint>
pinocchio::JointIndex add(std::size_t parent, const Joint &joint, const pinocchio::SE3 &pose)
{
    return model.addJoint(parent, joint, pose, "joint" + std::to_string(model.njoints));
}
} // namespace

extern "C" int load(const char *file)
{
    using namespace pinocchio;
    std::ifstream in(file);
    std::size_t parent;
    std::string kind;
    while (in >> parent >> kind) {
        SE3 pose;
        Eigen::Vector3d axis, com;
        Eigen::Matrix3d tensor;
        double mass;
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
                in >> pose.rotation()(i, j);
        for (int i = 0; i < 3; ++i)
            in >> pose.translation()(i);
        in >> axis(0) >> axis(1) >> axis(2) >> mass >> com(0) >> com(1) >> com(2);
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
                in >> tensor(i, j);
        JointIndex joint = 0;
        if (kind == "JointModelFreeFlyer") joint = add(parent, JointModelFreeFlyer(), pose);
        else if (kind == "JointModelRX") joint = add(parent, JointModelRX(), pose);
        else if (kind == "JointModelRY") joint = add(parent, JointModelRY(), pose);
        else if (kind == "JointModelRZ") joint = add(parent, JointModelRZ(), pose);
        else if (kind == "JointModelPX") joint = add(parent, JointModelPX(), pose);
        else if (kind == "JointModelPY") joint = add(parent, JointModelPY(), pose);
        else if (kind == "JointModelPZ") joint = add(parent, JointModelPZ(), pose);
        else if (kind == "JointModelRevoluteUnaligned")
            joint = add(parent, JointModelRevoluteUnaligned(axis), pose);
        else if (kind == "JointModelPrismaticUnaligned")
            joint = add(parent, JointModelPrismaticUnaligned(axis), pose);
        else return 0;
        model.appendBodyToJoint(joint, Inertia(mass, com, tensor), SE3::Identity());
    }
    data = new Data(model);
    for (int i = 0; i < 16; ++i) {
        q.push_back(neutral(model) );
        q.back().tail(model.nq > 7 ? model.nq - 7 : model.nq).setRandom();
        v.push_back(Eigen::VectorXd::Random(model.nv));
        a.push_back(Eigen::VectorXd::Random(model.nv));
    }
    return model.nv;
}

/// Seconds for one mass matrix and one vector of forces, or (2) for the derivatives of the forces,
/// (3) inverse dynamics, (4) forward dynamics, (5) the mass matrix, (6) the derivatives of forward
/// dynamics.
extern "C" double run(int times, int what)
{
    using namespace pinocchio;
    const auto convention = what == 1 ? Convention::WORLD : Convention::LOCAL;
    const auto start = std::chrono::steady_clock::now();
    for (int i = 0; i < times; ++i) {
        if (what == 2) {
            computeRNEADerivatives(model, *data, q[i % 16], v[i % 16], a[i % 16]);
            sink += data->dtau_dq(0, 0);
            continue;
        }
        if (what == 3) {
            sink += rnea(model, *data, q[i % 16], v[i % 16], a[i % 16])[0];
            continue;
        }
        if (what == 4) {
            sink += aba(model, *data, q[i % 16], v[i % 16], a[i % 16])[0];
            continue;
        }
        if (what == 5) {
            sink += crba(model, *data, q[i % 16], convention)(0, 0);
            continue;
        }
        if (what == 6) {
            computeABADerivatives(model, *data, q[i % 16], v[i % 16], a[i % 16]);
            sink += data->ddq_dq(0, 0);
            continue;
        }
        crba(model, *data, q[i % 16], convention);
        nonLinearEffects(model, *data, q[i % 16], v[i % 16]);
        sink += data->M(0, 0) + data->nle[0];
    }
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
    return took.count() / times;
}
