"""A minimal FMU in C, to measure the cost of FMPy itself."""

from __future__ import annotations

import subprocess
import sys
import zipfile
from pathlib import Path

OUTPUTS = 8

_DESCRIPTION = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="Native" guid="native">
<CoSimulation modelIdentifier="Native" canHandleVariableCommunicationStepSize="true"/>
<ModelVariables>
{variables}
</ModelVariables>
<ModelStructure><Outputs>{outputs}</Outputs></ModelStructure>
</fmiModelDescription>
"""

_SOURCE = """
#include <stdlib.h>
#include <stddef.h>
typedef double R; typedef unsigned V; typedef int I; typedef void *C; typedef const char *S;
#define OK(name, ...) I name(__VA_ARGS__) { return 0; }
C fmi2Instantiate(S n, I k, S g, S r, const void *f, I v, I l) { return calloc(1, sizeof(R)); }
void fmi2FreeInstance(C c) { free(c); }
I fmi2DoStep(C c, R t, R h, I n) { *(R *)c = t + h; return 0; }
I fmi2GetReal(C c, const V *vr, size_t n, R *out) {
    for (size_t i = 0; i < n; i++) out[i] = *(R *)c * vr[i];
    return 0;
}
OK(fmi2SetupExperiment, C c, I d, R t, R s, I e, R p)
OK(fmi2EnterInitializationMode, C c)
OK(fmi2ExitInitializationMode, C c)
OK(fmi2Terminate, C c)
OK(fmi2Reset, C c)
OK(fmi2SetDebugLogging, C c, I l, size_t n, const S *k)
OK(fmi2GetInteger, C c, const V *v, size_t n, I *x)
OK(fmi2GetBoolean, C c, const V *v, size_t n, I *x)
OK(fmi2GetString, C c, const V *v, size_t n, S *x)
OK(fmi2SetReal, C c, const V *v, size_t n, const R *x)
OK(fmi2SetInteger, C c, const V *v, size_t n, const I *x)
OK(fmi2SetBoolean, C c, const V *v, size_t n, const I *x)
OK(fmi2SetString, C c, const V *v, size_t n, const S *x)
OK(fmi2GetFMUstate, C c, C *s)
OK(fmi2SetFMUstate, C c, C s)
OK(fmi2FreeFMUstate, C c, C *s)
OK(fmi2SerializedFMUstateSize, C c, C s, size_t *n)
OK(fmi2SerializeFMUstate, C c, C s, char *b, size_t n)
OK(fmi2DeSerializeFMUstate, C c, const char *b, size_t n, C *s)
OK(fmi2GetDirectionalDerivative, C c, const V *u, size_t n, const V *k, size_t m, const R *d, R *x)
OK(fmi2SetRealInputDerivatives, C c, const V *v, size_t n, const I *o, const R *x)
OK(fmi2GetRealOutputDerivatives, C c, const V *v, size_t n, const I *o, R *x)
OK(fmi2CancelStep, C c)
OK(fmi2GetStatus, C c, I k, I *s)
OK(fmi2GetRealStatus, C c, I k, R *s)
OK(fmi2GetIntegerStatus, C c, I k, I *s)
OK(fmi2GetBooleanStatus, C c, I k, I *s)
OK(fmi2GetStringStatus, C c, I k, S *s)
S fmi2GetTypesPlatform(void) { return "default"; }
S fmi2GetVersion(void) { return "2.0"; }
"""


def native_fmu(folder: Path) -> Path:
    """Compile and pack the FMU; needs a C compiler on Linux.

    Parameters
    ----------
    folder : of the FMU
    """
    source, library = folder / "native.c", folder / "Native.so"
    source.write_text(_SOURCE)
    subprocess.run(["cc", "-O2", "-shared", "-fPIC", "-o", library, source], check=True)
    variables = "\n".join(
        f'<ScalarVariable name="y{k}" valueReference="{k}" causality="output"><Real/></ScalarVariable>'
        for k in range(OUTPUTS)
    )
    outputs = "".join(f'<Unknown index="{k + 1}"/>' for k in range(OUTPUTS))
    fmu = folder / "Native.fmu"
    with zipfile.ZipFile(fmu, "w") as archive:
        archive.writestr(
            "modelDescription.xml", _DESCRIPTION.format(variables=variables, outputs=outputs)
        )
        archive.write(
            library, f"binaries/{'linux64' if sys.maxsize > 2**32 else 'linux32'}/Native.so"
        )
    return fmu
