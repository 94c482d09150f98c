// FMI 2.0 co-simulation.

#include "model.h"
#include "state.h"

#include "fmi2Functions.h"

#include <stdlib.h>
#include <string.h>

typedef struct
{
    fmu_model_t                 *model;
    const fmi2CallbackFunctions *callbacks;
    char                        *name;
} instance_t;

static fmi2Status told(const instance_t *instance, bool ok)
{
    if (!ok && instance->callbacks->logger != NULL)
    {
        instance->callbacks->logger(instance->callbacks->componentEnvironment,
                                    instance->name,
                                    fmi2Error,
                                    "logStatusError",
                                    "%s",
                                    fmu_model_error(instance->model));
    }
    fmu_model_forget_error(instance->model);
    return ok ? fmi2OK : fmi2Error;
}

const char *fmi2GetTypesPlatform(void)
{
    return fmi2TypesPlatform;
}

const char *fmi2GetVersion(void)
{
    return fmi2Version;
}

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t count, const fmi2String categories[])
{
    (void)c, (void)on, (void)count, (void)categories; // errors are all there is
    return fmi2OK;
}

fmi2Component fmi2Instantiate(fmi2String                   name,
                              fmi2Type                     type,
                              fmi2String                   guid,
                              fmi2String                   resources,
                              const fmi2CallbackFunctions *callbacks,
                              fmi2Boolean                  visible,
                              fmi2Boolean                  logs)
{
    (void)resources, (void)visible, (void)logs;
    instance_t *instance = NULL;
    if (type != fmi2CoSimulation || guid == NULL || strcmp(guid, fmu_token) != 0)
    {
        if (callbacks->logger != NULL)
        {
            callbacks->logger(callbacks->componentEnvironment,
                              name,
                              fmi2Error,
                              "logStatusError",
                              "guid %s: this FMU is for co-simulation and has %s",
                              guid,
                              fmu_token);
        }
        return NULL;
    }
    instance = calloc(1, sizeof *instance);
    if (instance != NULL)
    {
        instance->callbacks = callbacks;
        instance->name      = malloc(strlen(name) + 1);
        instance->model     = fmu_model_create();
        if (instance->name == NULL || instance->model == NULL)
        {
            fmi2FreeInstance(instance);
            return NULL;
        }
        memcpy(instance->name, name, strlen(name) + 1);
    }
    return instance;
}

void fmi2FreeInstance(fmi2Component c)
{
    instance_t *instance = c;
    if (instance != NULL)
    {
        fmu_model_destroy(instance->model);
        free(instance->name);
        free(instance);
    }
}

fmi2Status fmi2SetupExperiment(fmi2Component c,
                               fmi2Boolean   has_tolerance,
                               fmi2Real      tolerance,
                               fmi2Real      start_s,
                               fmi2Boolean   has_stop,
                               fmi2Real      stop_s)
{
    (void)c, (void)has_tolerance, (void)tolerance, (void)start_s, (void)has_stop, (void)stop_s;
    return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c)
{
    (void)c;
    return fmi2OK;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c)
{
    instance_t *instance = c;
    return told(instance, fmu_model_start(instance->model));
}

fmi2Status fmi2Terminate(fmi2Component c)
{
    (void)c;
    return fmi2OK;
}

fmi2Status fmi2Reset(fmi2Component c)
{
    instance_t *instance = c;
    fmu_model_reset(instance->model);
    return fmi2OK;
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference variables[], size_t count, fmi2Real values[])
{
    instance_t *instance = c;
    bool        ok       = true;
    for (size_t i = 0; ok && i < count; i++)
    {
        ok = fmu_model_get(instance->model, variables[i], &values[i]);
    }
    return told(instance, ok);
}

fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference variables[], size_t count, fmi2Boolean values[])
{
    instance_t *instance = c;
    bool        ok       = true;
    for (size_t i = 0; ok && i < count; i++)
    {
        double value = 0.0;
        ok           = fmu_model_get(instance->model, variables[i], &value);
        values[i]    = value != 0.0 ? fmi2True : fmi2False;
    }
    return told(instance, ok);
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference variables[], size_t count, const fmi2Real values[])
{
    instance_t *instance = c;
    return told(instance, fmu_model_set(instance->model, variables, count, values));
}

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state)
{
    const instance_t *instance = c;
    return fmu_state_save(instance->model, state) ? fmi2OK : fmi2Error;
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state)
{
    const instance_t *instance = c;
    return told(instance, fmu_state_load(instance->model, state));
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state)
{
    (void)c;
    fmu_state_free(state);
    return fmi2OK;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size)
{
    (void)c;
    *size = fmu_state_size(state);
    return fmi2OK;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size)
{
    (void)c;
    return fmu_state_to_bytes(state, bytes, size) ? fmi2OK : fmi2Error;
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state)
{
    (void)c;
    return fmu_state_from_bytes(bytes, size, state) ? fmi2OK : fmi2Error;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time_s, fmi2Real step_s, fmi2Boolean no_set_back)
{
    (void)no_set_back;
    const instance_t *instance = c;
    return told(instance, fmu_model_step(instance->model, time_s, step_s));
}

// What follows is what modelDescription.xml says that there is not: it is there to be found, and refuses. Nobody reads its parameters.
#ifdef __GNUC__
#pragma GCC diagnostic ignored "-Wunused-parameter"
#endif
// clang-format off: one row a function

#define VARIABLES const fmi2ValueReference v[], size_t count

// Variables of these types.
#define NONE(function, values) fmi2Status function(fmi2Component c, VARIABLES, values) { return count == 0 ? fmi2OK : fmi2Error; }

NONE(fmi2GetInteger, fmi2Integer values[])
NONE(fmi2GetString, fmi2String values[])
NONE(fmi2SetInteger, const fmi2Integer values[])
NONE(fmi2SetBoolean, const fmi2Boolean values[])
NONE(fmi2SetString, const fmi2String values[])

// Derivatives, and the status of a step that is not done when it returns.
#define REFUSE(function, status, ...) fmi2Status function(fmi2Component c, __VA_ARGS__) { return status; }

REFUSE(fmi2GetDirectionalDerivative, fmi2Error, VARIABLES, const fmi2ValueReference knowns[], size_t known_count, const fmi2Real known[],
       fmi2Real unknown[])
REFUSE(fmi2SetRealInputDerivatives, fmi2Error, VARIABLES, const fmi2Integer orders[], const fmi2Real values[])
REFUSE(fmi2GetRealOutputDerivatives, fmi2Error, VARIABLES, const fmi2Integer orders[], fmi2Real values[])
REFUSE(fmi2GetStatus, fmi2Discard, const fmi2StatusKind kind, fmi2Status *value)
REFUSE(fmi2GetRealStatus, fmi2Discard, const fmi2StatusKind kind, fmi2Real *value)
REFUSE(fmi2GetIntegerStatus, fmi2Discard, const fmi2StatusKind kind, fmi2Integer *value)
REFUSE(fmi2GetBooleanStatus, fmi2Discard, const fmi2StatusKind kind, fmi2Boolean *value)
REFUSE(fmi2GetStringStatus, fmi2Discard, const fmi2StatusKind kind, fmi2String *value)

fmi2Status fmi2CancelStep(fmi2Component c)
{
    return fmi2Error;
}
