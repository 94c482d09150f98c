// A PWM chip without hardware: sysfs shows what was set. With block_ms a write takes that long.

#include <linux/delay.h>
#include <linux/module.h>
#include <linux/platform_device.h>
#include <linux/pwm.h>

static unsigned int block_ms;
module_param(block_ms, uint, 0644);

static int mock_apply(struct pwm_chip *chip, struct pwm_device *pwm, const struct pwm_state *state)
{
    if (block_ms > 0)
    {
        msleep(block_ms); // 0 would be a tick of the kernel
    }
    return 0; // the core keeps the state
}

static const struct pwm_ops mock_ops = {.apply = mock_apply, .owner = THIS_MODULE};

static int mock_probe(struct platform_device *device)
{
    struct pwm_chip *chip = devm_kzalloc(&device->dev, sizeof *chip, GFP_KERNEL);
    if (chip == NULL)
    {
        return -ENOMEM;
    }
    chip->dev  = &device->dev;
    chip->ops  = &mock_ops;
    chip->npwm = 2;
    return devm_pwmchip_add(&device->dev, chip);
}

static struct platform_driver  mock_driver = {.probe = mock_probe, .driver = {.name = "mock_pwm"}};
static struct platform_device *mock_device;

static int __init mock_init(void)
{
    const int status = platform_driver_register(&mock_driver);
    if (status != 0)
    {
        return status;
    }
    mock_device = platform_device_register_simple("mock_pwm", PLATFORM_DEVID_NONE, NULL, 0);
    if (IS_ERR(mock_device))
    {
        platform_driver_unregister(&mock_driver);
        return PTR_ERR(mock_device);
    }
    return 0;
}

static void __exit mock_exit(void)
{
    platform_device_unregister(mock_device);
    platform_driver_unregister(&mock_driver);
}

module_init(mock_init);
module_exit(mock_exit);
MODULE_LICENSE("Dual MIT/GPL");
MODULE_DESCRIPTION("PWM chip without hardware, for tests");
