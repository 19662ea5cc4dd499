#pragma once

#include <nanobind/nanobind.h>

#include "diffsac/diffsac.h"

namespace diffsac::python {

namespace nb = nanobind;

/// What NB_OBJECT wants to be told of an object that may be of its class; here any may.
inline bool IsAnything(PyObject*) { return true; }

// Results are the dataclasses of diffsac/_results.py. Each has a class of its own here, so that signatures and stubs
// name it.
#define DIFFSAC_PYTHON_RESULT(Name)                                        \
  class Py##Name : public nb::object {                                     \
    NB_OBJECT(Py##Name, nb::object, "diffsac._results." #Name, IsAnything) \
    static constexpr const char* kClass = #Name;                           \
  };

DIFFSAC_PYTHON_RESULT(Estimate)
DIFFSAC_PYTHON_RESULT(TwoViewEstimate)
DIFFSAC_PYTHON_RESULT(UnknownFocalEstimate)
DIFFSAC_PYTHON_RESULT(AbsolutePoseEstimate)
DIFFSAC_PYTHON_RESULT(RigidMotionEstimate)
DIFFSAC_PYTHON_RESULT(SimilarityEstimate)
DIFFSAC_PYTHON_RESULT(MultiModelEstimate)
DIFFSAC_PYTHON_RESULT(VanishingPointsEstimate)
#undef DIFFSAC_PYTHON_RESULT

/// The GIL is held.
PyEstimate ToPython(const LineEstimate& estimate);
PyEstimate ToPython(const PlaneEstimate& estimate);
PyTwoViewEstimate ToPython(const TwoViewEstimate& estimate);
PyUnknownFocalEstimate ToPython(const UnknownFocalEstimate& estimate);
PyAbsolutePoseEstimate ToPython(const AbsolutePoseEstimate& estimate);
PyRigidMotionEstimate ToPython(const RigidMotionEstimate& estimate);
PySimilarityEstimate ToPython(const SimilarityEstimate& estimate);
template <class Model>
PyMultiModelEstimate ToPython(const MultiModelEstimate<Model>& estimate);
PyVanishingPointsEstimate ToPython(const VanishingPointsEstimate& estimate);

}  // namespace diffsac::python
