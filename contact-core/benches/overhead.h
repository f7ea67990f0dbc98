/* The problem of overhead.rs for its two rivals in C and C++; the formulas and the order of operations are the same. */
#ifndef OVERHEAD_H
#define OVERHEAD_H

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

/* min sum of (x_i - c_i)^2 / 2 + x_i^4 / 4 subject to sums of WIDTH neighbours <= LIMIT and 0 <= x <= 1 */
enum { N = 100000, WIDTH = 20, M = N / WIDTH };
static const double LIMIT = 5.0, START = 0.2;

static double centre(int i) { return (double)((long)i * 7919 % 1000) / 500.0 - 0.5; }

static double objective(const double *c, const double *x) {
    double sum = 0.0;
    int i;
    for (i = 0; i < N; ++i) {
        const double d = x[i] - c[i];
        sum += 0.5 * d * d + 0.25 * x[i] * x[i] * x[i] * x[i];
    }
    return sum;
}

static void gradient(const double *c, const double *x, double *gradient) {
    int i;
    for (i = 0; i < N; ++i) {
        gradient[i] = (x[i] - c[i]) + x[i] * x[i] * x[i];
    }
}

static void constraints(const double *x, double *g) {
    int i, k;
    for (i = 0; i < M; ++i) {
        double sum = 0.0;
        for (k = 0; k < WIDTH; ++k) {
            sum += x[WIDTH * i + k];
        }
        g[i] = sum;
    }
}

static void jacobian(double *values) {
    int k;
    for (k = 0; k < N; ++k) {
        values[k] = 1.0;
    }
}

static void jacobian_places(int *rows, int *cols) {
    int k;
    for (k = 0; k < N; ++k) {
        rows[k] = k / WIDTH;
        cols[k] = k;
    }
}

static void hessian(const double *x, double factor, double *values) {
    int i;
    for (i = 0; i < N; ++i) {
        values[i] = factor * (1.0 + 3.0 * x[i] * x[i]);
    }
}

static void hessian_places(int *rows, int *cols) {
    int i;
    for (i = 0; i < N; ++i) {
        rows[i] = cols[i] = i;
    }
}

static double *array(int n, double value) {
    double *values = (double *)malloc((size_t)n * sizeof(double));
    int i;
    if (values == NULL) {
        exit(2);
    }
    for (i = 0; i < n; ++i) {
        values[i] = value;
    }
    return values;
}

static double cpu_seconds(void) { return (double)clock() / CLOCKS_PER_SEC; }

/* Splits an argument such as "i:print_level=0" in place: the kind, the name, the value. */
static char split(char *argument, char **name, char **value) {
    char *equals = strchr(argument, '=');
    if (equals == NULL || strlen(argument) < 3) {
        exit(2);
    }
    *equals = 0;
    *name = argument + 2;
    *value = equals + 1;
    return argument[0];
}

static void report(double seconds, int status, int iterations, double value) {
    printf("%.9f %d %d %.17e\n", seconds, status, iterations, value);
}

#endif
