// FMI 3.0 co-simulation.

#include "model.h"
#include "state.h"

#include "fmi3Functions.h"

#include <stdlib.h>
#include <string.h>

typedef struct
{
    fmu_model_t            *model;
    fmi3InstanceEnvironment environment;
    fmi3LogMessageCallback  log; ///< null: there is none
    bool                    logs;
} instance_t;

static const char category[] = "logStatusError";

static fmi3Status told(const instance_t *instance, bool ok)
{
    if (!ok && instance->logs && instance->log != NULL)
    {
        instance->log(instance->environment, fmi3Error, category, fmu_model_error(instance->model));
    }
    fmu_model_forget_error(instance->model);
    return ok ? fmi3OK : fmi3Error;
}

const char *fmi3GetVersion(void)
{
    return fmi3Version;
}

fmi3Status fmi3SetDebugLogging(fmi3Instance c, fmi3Boolean on, size_t count, const fmi3String categories[])
{
    instance_t *instance = c;
    bool        is_meant = count == 0;
    for (size_t i = 0; i < count; i++)
    {
        is_meant = is_meant || strcmp(categories[i], category) == 0;
    }
    instance->logs = is_meant ? on : instance->logs;
    return fmi3OK;
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String                     name,
                                         fmi3String                     token,
                                         fmi3String                     resources,
                                         fmi3Boolean                    visible,
                                         fmi3Boolean                    logs,
                                         fmi3Boolean                    has_events,
                                         fmi3Boolean                    may_return_early,
                                         const fmi3ValueReference       intermediate[],
                                         size_t                         intermediate_count,
                                         fmi3InstanceEnvironment        environment,
                                         fmi3LogMessageCallback         log,
                                         fmi3IntermediateUpdateCallback update)
{
    (void)name, (void)resources, (void)visible, (void)has_events, (void)may_return_early;
    (void)intermediate, (void)intermediate_count, (void)update;
    if (token == NULL || strcmp(token, fmu_token) != 0)
    {
        if (logs && log != NULL)
        {
            log(environment, fmi3Error, category, "the instantiation token is not this FMU's");
        }
        return NULL;
    }
    instance_t *instance = calloc(1, sizeof *instance);
    if (instance != NULL)
    {
        *instance = (instance_t){.model = fmu_model_create(), .environment = environment, .log = log, .logs = logs};
        if (instance->model == NULL)
        {
            free(instance);
            return NULL;
        }
    }
    return instance;
}

void fmi3FreeInstance(fmi3Instance c)
{
    instance_t *instance = c;
    if (instance != NULL)
    {
        fmu_model_destroy(instance->model);
        free(instance);
    }
}

fmi3Status fmi3EnterInitializationMode(fmi3Instance c,
                                       fmi3Boolean  has_tolerance,
                                       fmi3Float64  tolerance,
                                       fmi3Float64  start_s,
                                       fmi3Boolean  has_stop,
                                       fmi3Float64  stop_s)
{
    (void)has_tolerance, (void)tolerance, (void)has_stop, (void)stop_s;
    const instance_t *instance = c;
    fmu_model_set_time(instance->model, start_s);
    return fmi3OK;
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance c)
{
    const instance_t *instance = c;
    return told(instance, fmu_model_start(instance->model));
}

fmi3Status fmi3Terminate(fmi3Instance c)
{
    (void)c;
    return fmi3OK;
}

fmi3Status fmi3Reset(fmi3Instance c)
{
    const instance_t *instance = c;
    fmu_model_reset(instance->model);
    return fmi3OK;
}

fmi3Status fmi3GetFloat64(fmi3Instance             c,
                          const fmi3ValueReference variables[],
                          size_t                   count,
                          fmi3Float64              values[],
                          size_t                   value_count)
{
    const instance_t *instance = c;
    bool              ok       = true;
    if (count != value_count)
    {
        return fmi3Error;
    }
    for (size_t i = 0; ok && i < count; i++)
    {
        ok = fmu_model_get(instance->model, variables[i], &values[i]);
    }
    return told(instance, ok);
}

fmi3Status fmi3GetBoolean(fmi3Instance             c,
                          const fmi3ValueReference variables[],
                          size_t                   count,
                          fmi3Boolean              values[],
                          size_t                   value_count)
{
    const instance_t *instance = c;
    bool              ok       = true;
    if (count != value_count)
    {
        return fmi3Error;
    }
    for (size_t i = 0; ok && i < count; i++)
    {
        double value = 0.0;
        ok           = fmu_model_get(instance->model, variables[i], &value);
        values[i]    = value != 0.0;
    }
    return told(instance, ok);
}

fmi3Status fmi3SetFloat64(fmi3Instance             c,
                          const fmi3ValueReference variables[],
                          size_t                   count,
                          const fmi3Float64        values[],
                          size_t                   value_count)
{
    const instance_t *instance = c;
    return count == value_count ? told(instance, fmu_model_set(instance->model, variables, count, values)) : fmi3Error;
}

fmi3Status fmi3GetFMUState(fmi3Instance c, fmi3FMUState *state)
{
    const instance_t *instance = c;
    return fmu_state_save(instance->model, state) ? fmi3OK : fmi3Error;
}

fmi3Status fmi3SetFMUState(fmi3Instance c, fmi3FMUState state)
{
    const instance_t *instance = c;
    return told(instance, fmu_state_load(instance->model, state));
}

fmi3Status fmi3FreeFMUState(fmi3Instance c, fmi3FMUState *state)
{
    (void)c;
    fmu_state_free(state);
    return fmi3OK;
}

fmi3Status fmi3SerializedFMUStateSize(fmi3Instance c, fmi3FMUState state, size_t *size)
{
    (void)c;
    *size = fmu_state_size(state);
    return fmi3OK;
}

fmi3Status fmi3SerializeFMUState(fmi3Instance c, fmi3FMUState state, fmi3Byte bytes[], size_t size)
{
    (void)c;
    return fmu_state_to_bytes(state, bytes, size) ? fmi3OK : fmi3Error;
}

fmi3Status fmi3DeserializeFMUState(fmi3Instance c, const fmi3Byte bytes[], size_t size, fmi3FMUState *state)
{
    (void)c;
    return fmu_state_from_bytes(bytes, size, state) ? fmi3OK : fmi3Error;
}

fmi3Status fmi3DoStep(fmi3Instance c,
                      fmi3Float64  time_s,
                      fmi3Float64  step_s,
                      fmi3Boolean  no_set_back,
                      fmi3Boolean *needs_events,
                      fmi3Boolean *terminates,
                      fmi3Boolean *returned_early,
                      fmi3Float64 *last_s)
{
    (void)no_set_back;
    const instance_t *instance = c;
    const bool        ok       = fmu_model_step(instance->model, time_s, step_s);
    *needs_events              = fmi3False;
    *terminates                = fmi3False;
    *returned_early            = fmi3False;
    *last_s                    = ok ? time_s + step_s : time_s;
    return told(instance, ok);
}

// What follows is what modelDescription.xml says that there is not: it is there to be found, and refuses. Nobody reads its parameters.
#ifdef __GNUC__
#pragma GCC diagnostic ignored "-Wunused-parameter"
#endif
// clang-format off: one row a function

// Variables of these types.
#define GET_NONE(type)                                                                                                              \
    fmi3Status fmi3Get##type(fmi3Instance c, const fmi3ValueReference v[], size_t count, fmi3##type values[], size_t value_count)   \
    {                                                                                                                               \
        return count == 0 ? fmi3OK : fmi3Error;                                                                                     \
    }
#define SET_NONE(type)                                                                                                                  \
    fmi3Status fmi3Set##type(fmi3Instance c, const fmi3ValueReference v[], size_t count, const fmi3##type values[], size_t value_count) \
    {                                                                                                                                   \
        return count == 0 ? fmi3OK : fmi3Error;                                                                                         \
    }
GET_NONE(Float32) GET_NONE(Int8) GET_NONE(UInt8) GET_NONE(Int16) GET_NONE(UInt16) GET_NONE(Int32) GET_NONE(UInt32) GET_NONE(Int64)
GET_NONE(UInt64) GET_NONE(String)
SET_NONE(Float32) SET_NONE(Int8) SET_NONE(UInt8) SET_NONE(Int16) SET_NONE(UInt16) SET_NONE(Int32) SET_NONE(UInt32) SET_NONE(Int64)
SET_NONE(UInt64) SET_NONE(Boolean) SET_NONE(String)

// Everything else.
#define REFUSE(name, ...) fmi3Status name(fmi3Instance c, __VA_ARGS__) { return fmi3Error; }
#define REFUSE_ALONE(name) fmi3Status name(fmi3Instance c) { return fmi3Error; }
#define VARIABLES const fmi3ValueReference v[], size_t count

REFUSE(fmi3GetBinary, VARIABLES, size_t sizes[], fmi3Binary values[], size_t value_count)
REFUSE(fmi3SetBinary, VARIABLES, const size_t sizes[], const fmi3Binary values[], size_t value_count)
REFUSE(fmi3GetClock, VARIABLES, fmi3Clock values[])
REFUSE(fmi3SetClock, VARIABLES, const fmi3Clock values[])
REFUSE(fmi3GetIntervalDecimal, VARIABLES, fmi3Float64 intervals[], fmi3IntervalQualifier qualifiers[])
REFUSE(fmi3GetIntervalFraction, VARIABLES, fmi3UInt64 counters[], fmi3UInt64 resolutions[], fmi3IntervalQualifier qualifiers[])
REFUSE(fmi3SetIntervalDecimal, VARIABLES, const fmi3Float64 intervals[])
REFUSE(fmi3SetIntervalFraction, VARIABLES, const fmi3UInt64 counters[], const fmi3UInt64 resolutions[])
REFUSE(fmi3GetShiftDecimal, VARIABLES, fmi3Float64 shifts[])
REFUSE(fmi3GetShiftFraction, VARIABLES, fmi3UInt64 counters[], fmi3UInt64 resolutions[])
REFUSE(fmi3SetShiftDecimal, VARIABLES, const fmi3Float64 shifts[])
REFUSE(fmi3SetShiftFraction, VARIABLES, const fmi3UInt64 counters[], const fmi3UInt64 resolutions[])
REFUSE(fmi3ActivateModelPartition, fmi3ValueReference clock, fmi3Float64 time_s)
REFUSE(fmi3GetNumberOfVariableDependencies, fmi3ValueReference variable, size_t *dependencies)
REFUSE(fmi3GetVariableDependencies, fmi3ValueReference dependent, size_t of[], fmi3ValueReference independents[], size_t on[],
       fmi3DependencyKind kinds[], size_t count)
REFUSE(fmi3GetDirectionalDerivative, VARIABLES, const fmi3ValueReference knowns[], size_t known_count, const fmi3Float64 seed[],
       size_t seed_count, fmi3Float64 sensitivity[], size_t sensitivity_count)
REFUSE(fmi3GetAdjointDerivative, VARIABLES, const fmi3ValueReference knowns[], size_t known_count, const fmi3Float64 seed[],
       size_t seed_count, fmi3Float64 sensitivity[], size_t sensitivity_count)
REFUSE(fmi3GetOutputDerivatives, VARIABLES, const fmi3Int32 orders[], fmi3Float64 values[], size_t value_count)
REFUSE_ALONE(fmi3EnterConfigurationMode)
REFUSE_ALONE(fmi3ExitConfigurationMode)
REFUSE_ALONE(fmi3EnterEventMode)
REFUSE_ALONE(fmi3EnterStepMode)
REFUSE_ALONE(fmi3EvaluateDiscreteStates)
REFUSE(fmi3UpdateDiscreteStates, fmi3Boolean *again, fmi3Boolean *terminates, fmi3Boolean *nominals, fmi3Boolean *values,
       fmi3Boolean *has_next, fmi3Float64 *next_s)
REFUSE_ALONE(fmi3EnterContinuousTimeMode)
REFUSE(fmi3CompletedIntegratorStep, fmi3Boolean no_set_back, fmi3Boolean *events, fmi3Boolean *terminates)
REFUSE(fmi3SetTime, fmi3Float64 time_s)
REFUSE(fmi3SetContinuousStates, const fmi3Float64 states[], size_t count)
REFUSE(fmi3GetContinuousStates, fmi3Float64 states[], size_t count)
REFUSE(fmi3GetContinuousStateDerivatives, fmi3Float64 derivatives[], size_t count)
REFUSE(fmi3GetNominalsOfContinuousStates, fmi3Float64 nominals[], size_t count)
REFUSE(fmi3GetNumberOfContinuousStates, size_t *count)
REFUSE(fmi3GetEventIndicators, fmi3Float64 indicators[], size_t count)
REFUSE(fmi3GetNumberOfEventIndicators, size_t *count)

fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                          fmi3Boolean logs, fmi3InstanceEnvironment environment, fmi3LogMessageCallback log)
{
    return NULL;
}

fmi3Instance fmi3InstantiateScheduledExecution(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                               fmi3Boolean logs, fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
                                               fmi3ClockUpdateCallback update, fmi3LockPreemptionCallback lock,
                                               fmi3UnlockPreemptionCallback unlock)
{
    return NULL;
}
