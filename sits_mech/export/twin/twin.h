/* What does a calibrated sensor show, and what pressed on it? C99, no allocation, no state but what is handed over.
 *
 *   int sits_read(const real wrench[6], real L[SITS_COILS], int32_t codes[SITS_COILS])         slow wrench to readings
 *   int sits_read_pose(const real pose[6], real L[SITS_COILS], int32_t codes[SITS_COILS])      target's pose to readings
 *   int sits_estimate(const real L[SITS_COILS], real wrench[6])                                readings to slow wrench
 *   int sits_estimate_codes(const int32_t codes[SITS_COILS], real wrench[6])
 *   void sits_start(real state[SITS_STATE])                                                    at rest, long unloaded
 *   int sits_step(real state[SITS_STATE], const real wrench[6], real dt, real L[], int32_t codes[])
 *   int sits_recover(real state[SITS_STATE], const real L[SITS_COILS], real dt, real wrench[6])
 *
 * real is SITS_REAL: double, or what is defined before this file is included, such as float. A wrench is F_x, F_z, M,
 * F_y, M_x, M_z [N, N m], F_z > 0 pressing down; a pose d_h, d_v, alpha, d_y, alpha_x, alpha_z [m, rad]; L in henry.
 * Codes stay untouched without a converter. The arithmetic is that of twin.py, which has the formulas; all return the
 * same flags, which add up: SITS_OUTSIDE (held at the domain's edge, NaN at its middle), SITS_IGNORED (a component that
 * the map does not know is not what it was in the calibration), SITS_UNSOLVED (no single wrench shows the reading: it
 * is NaN), with it of codes SITS_FAULT_FLAGS (the part's error flags stand above a code), SITS_FAULT_FULL (full scale:
 * open, or out of range) or SITS_FAULT_ZERO (shorted, or it does not swing). dt > 0 [s]; a NaN stays in the state, until sits_start.
 * Functions of what the sensor has not (a map of poses, an inverse) are not there.
 *
 * sensor.h holds the numbers. Made by sits-mech; BSD-3-Clause.
 */
#ifndef SITS_TWIN_H
#define SITS_TWIN_H

#include <math.h>
#include <stddef.h>
#include <stdint.h>

#ifndef SITS_REAL
#define SITS_REAL double
#endif

#include "sensor.h"

enum { SITS_OUTSIDE = 1, SITS_IGNORED = 2, SITS_UNSOLVED = 4 };
enum { SITS_FAULT_FLAGS = 8, SITS_FAULT_FULL = 16, SITS_FAULT_ZERO = 32 };

#define SITS_STATE (SITS_WRENCH_D * (SITS_BRANCHES + 1))
#define SITS_STEPS 8 /* of Newton's method; then how long, how far out, and the last one, scaled */
#define SITS_LONGEST ((SITS_REAL)0.3)
#define SITS_REACH ((SITS_REAL)1.2)
#define SITS_SETTLED ((SITS_REAL)1e-3)
#define SITS_EDGE ((SITS_REAL)1e-5)

static inline SITS_REAL sits_held(SITS_REAL x, SITS_REAL most)
{
    return x < -most ? -most : x > most ? most : x;
}

static inline SITS_REAL sits_size(SITS_REAL x)
{
    return x < 0 ? -x : x;
}

/* Sums of products of Chebyshev's polynomials at x[d]; of slope, unless it is NULL, [d][outputs]. */
static inline void sits_map(int d, int terms, int outputs, const unsigned char *power, const SITS_REAL *coefficient,
                            const SITS_REAL *x, SITS_REAL *out, SITS_REAL *slope)
{
    SITS_REAL value[SITS_MOST_D][SITS_MOST_DEGREE + 2], rate[SITS_MOST_D][SITS_MOST_DEGREE + 2];
    for (int i = 0; i < d; ++i) {
        value[i][0] = 1;
        value[i][1] = x[i];
        for (int k = 2; k <= SITS_MOST_DEGREE; ++k)
            value[i][k] = 2 * x[i] * value[i][k - 1] - value[i][k - 2];
        if (slope != NULL) {
            rate[i][0] = 0;
            rate[i][1] = 1;
            for (int k = 2; k <= SITS_MOST_DEGREE; ++k)
                rate[i][k] = 2 * value[i][k - 1] + 2 * x[i] * rate[i][k - 1] - rate[i][k - 2];
        }
    }
    for (int c = 0; c < outputs; ++c)
        out[c] = 0;
    if (slope != NULL)
        for (int c = 0; c < d * outputs; ++c)
            slope[c] = 0;
    for (int t = 0; t < terms; ++t) {
        const unsigned char *k = power + t * d;
        const SITS_REAL *a = coefficient + t * outputs;
        SITS_REAL product = value[0][k[0]];
        for (int i = 1; i < d; ++i)
            product *= value[i][k[i]];
        for (int c = 0; c < outputs; ++c)
            out[c] += a[c] * product;
        if (slope != NULL)
            for (int j = 0; j < d; ++j) {
                SITS_REAL other = rate[j][k[j]];
                for (int i = 0; i < d; ++i)
                    if (i != j)
                        other *= value[i][k[i]];
                for (int c = 0; c < outputs; ++c)
                    slope[j * outputs + c] += a[c] * other;
            }
    }
}

/* Components of a wrench or pose as x within the box, NaN as its middle, and the flags. */
static inline int sits_scaled(int d, const int *column, const SITS_REAL *middle, const SITS_REAL *half,
                              const SITS_REAL *fixed, SITS_REAL same, const SITS_REAL *given, SITS_REAL *x)
{
    int flags = 0, known[6] = {0, 0, 0, 0, 0, 0};
    for (int i = 0; i < d; ++i) {
        const SITS_REAL at = (given[column[i]] - middle[i]) / half[i];
        known[column[i]] = 1;
        x[i] = at == at ? sits_held(at, 1) : 0;
        if (!(sits_size(at) <= 1 + SITS_EDGE))
            flags |= SITS_OUTSIDE;
    }
    for (int i = 0; i < 6; ++i)
        if (!known[i] && !(sits_size(given[i] - fixed[i]) <= same))
            flags |= SITS_IGNORED;
    return flags;
}

/* Sums of a map as inductances and codes. */
static inline void sits_shown(const SITS_REAL *change, const SITS_REAL *base, const int32_t *base_codes, SITS_REAL *L,
                              int32_t *codes)
{
    for (int c = 0; c < SITS_COILS; ++c) {
        L[c] = base[c] + change[c];
        if (SITS_CODES)
            codes[c] = base_codes[c] + (int32_t)lrint((double)change[(SITS_CODES ? SITS_COILS : 0) + c]);
    }
}

static inline int sits_read(const SITS_REAL wrench[6], SITS_REAL L[SITS_COILS], int32_t codes[SITS_COILS])
{
    SITS_REAL x[SITS_WRENCH_D], change[SITS_OUTPUTS];
    const int flags = sits_scaled(SITS_WRENCH_D, sits_wrench_column, sits_wrench_middle, sits_wrench_half,
                                  sits_wrench_fixed, sits_wrench_same, wrench, x);
    sits_map(SITS_WRENCH_D, SITS_WRENCH_TERMS, SITS_OUTPUTS, &sits_wrench_power[0][0], &sits_wrench_coefficient[0][0],
             x, change, NULL);
    sits_shown(change, sits_wrench_base, sits_wrench_base_codes, L, codes);
    return flags;
}

#if SITS_POSE_D
static inline int sits_read_pose(const SITS_REAL pose[6], SITS_REAL L[SITS_COILS], int32_t codes[SITS_COILS])
{
    SITS_REAL x[SITS_POSE_D], change[SITS_OUTPUTS];
    const int flags = sits_scaled(SITS_POSE_D, sits_pose_column, sits_pose_middle, sits_pose_half, sits_pose_fixed,
                                  sits_pose_same, pose, x);
    sits_map(SITS_POSE_D, SITS_POSE_TERMS, SITS_OUTPUTS, &sits_pose_power[0][0], &sits_pose_coefficient[0][0], x,
             change, NULL);
    sits_shown(change, sits_pose_base, sits_pose_base_codes, L, codes);
    return flags;
}
#endif

static inline void sits_start(SITS_REAL state[SITS_STATE])
{
    for (int i = 0; i < SITS_STATE; ++i)
        state[i] = 0;
}

/* The forces of load convolved with 1 + sum_j weight_j exp(-t / time_j), linear since the last step; state holds those
 * of the last load, then what each branch still lacks of its share. */
static inline void sits_passed(SITS_REAL state[SITS_STATE], const SITS_REAL load[6], SITS_REAL dt,
                               const SITS_REAL *weight, const SITS_REAL *time, SITS_REAL out[6])
{
    SITS_REAL rise[SITS_WRENCH_D];
    for (int i = 0; i < 6; ++i)
        out[i] = load[i];
    for (int i = 0; i < SITS_WRENCH_D; ++i) {
        rise[i] = load[sits_wrench_column[i]] - state[i];
        state[i] = load[sits_wrench_column[i]];
    }
    for (int j = 0; j < SITS_BRANCHES; ++j) {
        const SITS_REAL share = dt / time[j], lost = (SITS_REAL)-expm1((double)-share);
        SITS_REAL *lag = state + SITS_WRENCH_D * (j + 1);
        for (int i = 0; i < SITS_WRENCH_D; ++i) {
            lag[i] = lag[i] * (1 - lost) + weight[j] * (lost / share) * rise[i];
            out[sits_wrench_column[i]] += lag[i];
        }
    }
}

static inline int sits_step(SITS_REAL state[SITS_STATE], const SITS_REAL wrench[6], SITS_REAL dt,
                            SITS_REAL L[SITS_COILS], int32_t codes[SITS_COILS])
{
    SITS_REAL elastic[6];
    sits_passed(state, wrench, dt, sits_creep_weight, sits_creep_time, elastic);
    return sits_read(elastic, L, codes);
}

#if SITS_INVERSE
/* The slopes' columns [d][n] as Q R, in place; then R s = Q^T off. */
static inline void sits_least_squares(SITS_REAL Q[SITS_WRENCH_D][SITS_COILS], const SITS_REAL *off, SITS_REAL *s)
{
    SITS_REAL R[SITS_WRENCH_D][SITS_WRENCH_D];
    for (int i = 0; i < SITS_WRENCH_D; ++i) {
        SITS_REAL square = 0;
        for (int c = 0; c < SITS_COILS; ++c)
            square += Q[i][c] * Q[i][c];
        R[i][i] = (SITS_REAL)sqrt((double)square);
        s[i] = 0;
        for (int c = 0; c < SITS_COILS; ++c) {
            Q[i][c] /= R[i][i];
            s[i] += Q[i][c] * off[c];
        }
        for (int j = i + 1; j < SITS_WRENCH_D; ++j) {
            R[i][j] = 0;
            for (int c = 0; c < SITS_COILS; ++c)
                R[i][j] += Q[i][c] * Q[j][c];
            for (int c = 0; c < SITS_COILS; ++c)
                Q[j][c] -= R[i][j] * Q[i][c];
        }
    }
    for (int i = SITS_WRENCH_D - 1; i >= 0; --i) {
        for (int j = i + 1; j < SITS_WRENCH_D; ++j)
            s[i] -= R[i][j] * s[j];
        s[i] /= R[i][i];
    }
}

/* Whether no other wrench shows what x does. */
static inline int sits_alone(const SITS_REAL *x)
{
    int place = 0;
    if (!SITS_VALID)
        return 1;
    for (int i = 0; i < SITS_WRENCH_D; ++i) {
        const int last = sits_valid_nodes[i] - 1;
        const double near = rint(0.5 * ((double)x[i] + 1.0) * last);
        place = place * (last + 1) + (near < 0 ? 0 : near > last ? last : (int)near);
    }
    return sits_valid[place];
}

/* The wrench of readings less the base, over their scale; they are the outputs from `first` on. */
static inline int sits_found(const SITS_REAL off[SITS_COILS], int first, const SITS_REAL *scale,
                             const SITS_REAL towards[SITS_WRENCH_D][SITS_COILS + 1], int terms,
                             const unsigned char *power, const SITS_REAL *guess, const SITS_REAL *guess_base,
                             SITS_REAL wrench[6])
{
    SITS_REAL x[SITS_WRENCH_D], y[SITS_WRENCH_D], out[SITS_OUTPUTS], slope[SITS_WRENCH_D][SITS_OUTPUTS];
    SITS_REAL s[SITS_WRENCH_D], left[SITS_COILS], Q[SITS_WRENCH_D][SITS_COILS];
    int flags = 0, good = 1;
    for (int i = 0; i < SITS_WRENCH_D; ++i) {
        y[i] = towards[i][SITS_COILS];
        for (int c = 0; c < SITS_COILS; ++c)
            y[i] += towards[i][c] * off[c];
        y[i] = sits_held(y[i], 1);
    }
    sits_map(SITS_WRENCH_D, terms, SITS_WRENCH_D, power, guess, y, x, NULL);
    for (int i = 0; i < SITS_WRENCH_D; ++i)
        x[i] = sits_held(x[i] + guess_base[i], SITS_REACH);
    for (int step = 0; step <= SITS_STEPS; ++step) {
        sits_map(SITS_WRENCH_D, SITS_WRENCH_TERMS, SITS_OUTPUTS, &sits_wrench_power[0][0],
                 &sits_wrench_coefficient[0][0], x, out, step < SITS_STEPS ? &slope[0][0] : NULL);
        for (int c = 0; c < SITS_COILS; ++c)
            left[c] = off[c] - out[first + c] / scale[c];
        if (step == SITS_STEPS)
            break;
        for (int i = 0; i < SITS_WRENCH_D; ++i)
            for (int c = 0; c < SITS_COILS; ++c)
                Q[i][c] = slope[i][first + c] / scale[c];
        sits_least_squares(Q, left, s);
        for (int i = 0; i < SITS_WRENCH_D; ++i)
            x[i] = sits_held(x[i] + sits_held(s[i], SITS_LONGEST), SITS_REACH);
    }
    for (int i = 0; i < SITS_WRENCH_D; ++i) {
        good = good && sits_size(s[i]) < SITS_SETTLED;
        if (sits_size(x[i]) > 1 + sits_margin)
            flags |= SITS_OUTSIDE;
    }
    for (int c = 0; c < SITS_COILS; ++c)
        good = good && sits_size(left[c]) < sits_residual;
    good = good && sits_alone(x);
    for (int i = 0; i < 6; ++i)
        wrench[i] = good ? sits_wrench_fixed[i] : (SITS_REAL)NAN;
    for (int i = 0; good && i < SITS_WRENCH_D; ++i)
        wrench[sits_wrench_column[i]] =
            sits_wrench_middle[i] + sits_wrench_half[i] * sits_held(x[i], 1 + sits_margin);
    return flags | (good ? 0 : SITS_UNSOLVED);
}

static inline int sits_estimate(const SITS_REAL L[SITS_COILS], SITS_REAL wrench[6])
{
    SITS_REAL off[SITS_COILS];
    for (int c = 0; c < SITS_COILS; ++c)
        off[c] = (L[c] - sits_wrench_base[c]) / sits_scale_L[c];
    return sits_found(off, 0, sits_scale_L, sits_directions_L, SITS_GUESS_L_TERMS, &sits_guess_L_power[0][0],
                      &sits_guess_L_coefficient[0][0], sits_guess_L_base, wrench);
}

#if SITS_CODES
/* 0, or what is wrong with the first code that is of no coil; 32 bits as they are read, whatever their sign. */
static inline int sits_fault(const int32_t codes[SITS_COILS])
{
    for (int c = 0; c < SITS_COILS; ++c)
        if ((uint32_t)codes[c] > SITS_FULL)
            return SITS_FAULT_FLAGS;
        else if ((uint32_t)codes[c] == SITS_FULL || codes[c] == 0)
            return codes[c] == 0 ? SITS_FAULT_ZERO : SITS_FAULT_FULL;
    return 0;
}

static inline int sits_estimate_codes(const int32_t codes[SITS_COILS], SITS_REAL wrench[6])
{
    SITS_REAL off[SITS_COILS];
    const int fault = sits_fault(codes);
    for (int i = 0; i < 6 && fault != 0; ++i)
        wrench[i] = (SITS_REAL)NAN;
    if (fault != 0)
        return SITS_UNSOLVED | fault;
    for (int c = 0; c < SITS_COILS; ++c)
        off[c] = (SITS_REAL)(codes[c] - sits_wrench_base_codes[c]) / sits_scale_codes[c];
    return sits_found(off, SITS_COILS, sits_scale_codes, sits_directions_codes, SITS_GUESS_CODES_TERMS,
                      &sits_guess_codes_power[0][0], &sits_guess_codes_coefficient[0][0], sits_guess_codes_base,
                      wrench);
}
#endif

static inline int sits_recover(SITS_REAL state[SITS_STATE], const SITS_REAL L[SITS_COILS], SITS_REAL dt,
                               SITS_REAL wrench[6])
{
    SITS_REAL elastic[6];
    const int flags = sits_estimate(L, elastic);
    sits_passed(state, elastic, dt, sits_relaxation_weight, sits_relaxation_time, wrench);
    return flags;
}
#endif
#endif
